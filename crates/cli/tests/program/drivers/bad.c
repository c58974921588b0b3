/* Vulkan drivers that nobody wants: CRASHES, HANGS or EXITS when the loader asks for its version; or one that hands everything on to
   the one in REAL, but for IS_SILENT computes nothing, and for NEVER_WAITS has no memory to wait with. */
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

static int32_t no_memory(void) { return -1; }

static lookup device_lookup;

static int is_dispatch(const char *name) {
    return strncmp(name, "vkCmdDispatch", strlen("vkCmdDispatch")) == 0;
}

static function instead_of(const char *name) {
#if defined IS_SILENT
    if (is_dispatch(name)) return nothing;
#elif defined NEVER_WAITS
    if (strcmp(name, "vkWaitForFences") == 0) return (function)no_memory;
#endif
    return NULL;
}

static function of_device(void *device, const char *name) {
    function instead = instead_of(name);
    return instead ? instead : device_lookup(device, name);
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
    if (instead_of(name)) return instead_of(name);
    if (strcmp(name, "vkGetDeviceProcAddr") == 0) {
        device_lookup = (lookup)of_instance(instance, name);
        return device_lookup ? (function)of_device : NULL;
    }
    return of_instance(instance, name);
}

function vk_icdGetPhysicalDeviceProcAddr(void *instance, const char *name) {
    return ((lookup)dlsym(real(), "vk_icdGetPhysicalDeviceProcAddr"))(instance, name);
}
