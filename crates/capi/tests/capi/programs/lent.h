/* A Vulkan device as a renderer has it, to lend. */
#ifndef LENT_H
#define LENT_H
#include "check.h"
#include <vulkan/vulkan.h>

struct Lent {
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
};

/* The first device with a queue that computes. There is one where this program is run. */
static inline struct Lent lent(void) {
    struct Lent lent;
    VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO, NULL, "test", 1, NULL, 0,
                                     VK_API_VERSION_1_1};
    VkInstanceCreateInfo create = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, NULL, 0, &application, 0, NULL, 0, NULL};
    CHECK(vkCreateInstance(&create, NULL, &lent.instance) == VK_SUCCESS);
    uint32_t count = 1;
    CHECK(vkEnumeratePhysicalDevices(lent.instance, &count, &lent.physical_device) >= 0 && count == 1);
    VkQueueFamilyProperties families[16];
    count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(lent.physical_device, &count, families);
    lent.family = 0;
    while (lent.family < count && !(families[lent.family].queueFlags & VK_QUEUE_COMPUTE_BIT)) lent.family++;
    CHECK(lent.family < count);
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {
        VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, NULL, 0, lent.family, 1, &priority};
    VkDeviceCreateInfo device = {
        VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, NULL, 0, 1, &queue, 0, NULL, 0, NULL, NULL};
    CHECK(vkCreateDevice(lent.physical_device, &device, NULL, &lent.device) == VK_SUCCESS);
    vkGetDeviceQueue(lent.device, lent.family, 0, &lent.queue);
    return lent;
}

static inline void destroy(struct Lent lent) {
    vkDestroyDevice(lent.device, NULL);
    vkDestroyInstance(lent.instance, NULL);
}

static inline RhytidVulkanHost host(struct Lent lent, PFN_vkGetInstanceProcAddr get) {
    RhytidVulkanHost host = {(RhytidGetInstanceProcAddr)get, lent.instance, lent.physical_device,
                             lent.device, lent.queue, lent.family};
    return host;
}

#endif
