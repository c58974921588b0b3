/* Vulkan drivers that nobody wants: CRASHES, HANGS or EXITS when the loader asks for its version; or, for IS_SILENT, a driver that
   hands everything on to the one in REAL, but computes nothing. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void (*function)(void);
typedef function (*lookup)(void *, const char *);

static void *real(void) {
    static void *library;
    return library ? library : (library = dlopen(getenv("REAL"), RTLD_NOW | RTLD_LOCAL));
}

static void nothing(void) {}

static lookup device_lookup;

static int is_dispatch(const char *name) {
    return strncmp(name, "vkCmdDispatch", strlen("vkCmdDispatch")) == 0;
}

static function of_device(void *device, const char *name) {
    return is_dispatch(name) ? nothing : device_lookup(device, name);
}

int32_t vk_icdNegotiateLoaderICDInterfaceVersion(uint32_t *version) {
#if defined CRASHES
    raise(SIGSEGV);
#elif defined HANGS
    for (;;) pause();
#elif defined EXITS
    _exit(0);
#endif
    return ((int32_t(*)(uint32_t *))dlsym(real(), "vk_icdNegotiateLoaderICDInterfaceVersion"))(version);
}

function vk_icdGetInstanceProcAddr(void *instance, const char *name) {
    lookup of_instance = (lookup)dlsym(real(), "vk_icdGetInstanceProcAddr");
    if (is_dispatch(name)) return nothing;
    if (strcmp(name, "vkGetDeviceProcAddr") == 0) {
        device_lookup = (lookup)of_instance(instance, name);
        return device_lookup ? (function)of_device : NULL;
    }
    return of_instance(instance, name);
}

function vk_icdGetPhysicalDeviceProcAddr(void *instance, const char *name) {
    return ((lookup)dlsym(real(), "vk_icdGetPhysicalDeviceProcAddr"))(instance, name);
}
