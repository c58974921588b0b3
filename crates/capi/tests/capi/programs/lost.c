/* A renderer's device that is lost: the driver's answer to a submission is replaced, as Vulkan's loader allows. */
#include "lent.h"

static int is_lost = 0;

static VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t count, const VkSubmitInfo *infos, VkFence fence) {
    return is_lost ? VK_ERROR_DEVICE_LOST : vkQueueSubmit(queue, count, infos, fence);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char *name) {
    return strcmp(name, "vkQueueSubmit") == 0 ? (PFN_vkVoidFunction)submit : vkGetDeviceProcAddr(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_instance(VkInstance instance, const char *name) {
    return strcmp(name, "vkGetDeviceProcAddr") == 0 ? (PFN_vkVoidFunction)of_device
                                                    : vkGetInstanceProcAddr(instance, name);
}

int main(int words, char **word) {
    CHECK(words == 2);
    RhytidRig *rig;
    OK(rhytid_rig_open(word[1], &rig));
    struct Lent own = lent();
    RhytidVulkanHost lending = host(own, of_instance);
    RhytidVulkan *vulkan;
    RhytidAnimator *animator, *none;
    OK(rhytid_vulkan_new(&lending, &vulkan));
    OK(rhytid_vulkan_animator(vulkan, rig, NULL, &animator));
    RhytidAnimatorOptions options = rhytid_animator_options();
    options.device = "vulkan:0";
    FAILS(RHYTID_STATUS_ARGUMENT, "expected NULL", rhytid_vulkan_animator(vulkan, rig, &options, &none));

    size_t numbers = 3 * rhytid_rig_handles(rig), count;
    const float *rest = rhytid_rig_handle_rest(rig), *lent_positions;
    OK(rhytid_animator_evaluate(animator, rest, numbers));
    OK(rhytid_animator_map(animator, RHYTID_STAGE_POSITIONS, &lent_positions, &count));
    CHECK(count == 3 * rhytid_rig_vertices(rig));
    for (size_t i = 0; i < count; i++) {
        float off = lent_positions[i] - rhytid_rig_rest(rig)[i];
        CHECK(off < 1e-3f && off > -1e-3f);
    }
    /* One batch signals a semaphore, and the next one waits for it. */
    VkSemaphoreCreateInfo create = {VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, NULL, 0};
    VkSemaphore semaphore;
    CHECK(vkCreateSemaphore(own.device, &create, NULL, &semaphore) == VK_SUCCESS);
    uint64_t raw = (uint64_t)semaphore;
    FAILS(RHYTID_STATUS_INPUT_MISMATCH, "multiple",
          rhytid_vulkan_evaluate(animator, rest, numbers - 1, NULL, 0, &raw, 1));
    OK(rhytid_vulkan_evaluate(animator, rest, numbers, NULL, 0, &raw, 1));
    OK(rhytid_vulkan_evaluate(animator, rest, numbers, &raw, 1, NULL, 0));
    RhytidVulkanSlice slices[2] = {{0, 9, 9}, {0, 9, 9}};
    OK(rhytid_vulkan_results(animator, RHYTID_STAGE_NORMALS, slices, 2, &count));
    CHECK(count == 1 && slices[0].buffer != 0 && slices[0].first_frame == 0 && slices[0].frames == 1);
    CHECK(slices[1].frames == 9);
    FAILS(RHYTID_STATUS_ARGUMENT, "stage is 6", rhytid_vulkan_results(animator, 6, slices, 2, &count));
    FAILS(RHYTID_STATUS_ARGUMENT, "call is null", rhytid_vulkan_with_queue(vulkan, NULL, NULL));
    OK(rhytid_animator_map(animator, RHYTID_STAGE_NORMALS, &lent_positions, &count));
    vkDestroySemaphore(own.device, semaphore, NULL);

    is_lost = 1;
    FAILS(RHYTID_STATUS_DEVICE_LOST, "vulkan", rhytid_animator_evaluate(animator, rest, numbers));
    FAILS(RHYTID_STATUS_INPUT_EMPTY, "failed on the device",
          rhytid_animator_map(animator, RHYTID_STAGE_POSITIONS, &lent_positions, &count));
    CHECK(lent_positions == NULL && count == 0);
    FAILS(RHYTID_STATUS_DEVICE_LOST, "vulkan", rhytid_vulkan_animator(vulkan, rig, NULL, &none));
    rhytid_animator_free(animator);
    rhytid_vulkan_free(vulkan);

    /* The program goes on with another device. */
    options.device = "cpu:0";
    OK(rhytid_animator_new(rig, &options, &animator));
    OK(rhytid_animator_evaluate(animator, rest, numbers));
    rhytid_animator_free(animator);
    rhytid_rig_free(rig);
    destroy(own);
    puts("a lost device is an error");
    return 0;
}
