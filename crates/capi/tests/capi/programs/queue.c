/* Two threads share a renderer's device and its queue: each has an animator, and submits work of its own. */
#include "lent.h"
#include <pthread.h>

enum { FRAMES = 12 };

static RhytidRig *rig;
static RhytidTake *take;
static RhytidVulkan *vulkan;
static struct Lent own;
static int submitted[2];

static void submit(void *user) {
    /* Nothing to do, but the queue must not be used by two threads at once. */
    int *count = user;
    CHECK(vkQueueSubmit(own.queue, 0, NULL, VK_NULL_HANDLE) == VK_SUCCESS);
    CHECK(vkQueueWaitIdle(own.queue) == VK_SUCCESS);
    ++*count;
}

static void evaluate(float *results, int *count) {
    RhytidAnimator *animator;
    OK(rhytid_vulkan_animator(vulkan, rig, NULL, &animator));
    size_t numbers = 3 * rhytid_rig_handles(rig), values = rhytid_animator_values(animator, RHYTID_STAGE_POSITIONS);
    for (size_t frame = 0; frame < FRAMES; frame++) {
        OK(rhytid_animator_evaluate(animator, rhytid_take_positions(take) + frame * numbers, numbers));
        OK(rhytid_vulkan_with_queue(vulkan, submit, count));
        OK(rhytid_animator_read(animator, RHYTID_STAGE_POSITIONS, results + frame * values, values));
    }
    rhytid_animator_free(animator);
}

static float *of_thread[2];

static void *run(void *argument) {
    size_t i = (size_t)argument;
    evaluate(of_thread[i], &submitted[i]);
    return NULL;
}

int main(int words, char **word) {
    CHECK(words == 3);
    OK(rhytid_rig_open(word[1], &rig));
    OK(rhytid_take_open(word[2], rig, RHYTID_MISSING_ERROR, &take));
    own = lent();
    RhytidVulkanHost lending = host(own, vkGetInstanceProcAddr);
    OK(rhytid_vulkan_new(&lending, &vulkan));
    size_t bytes = FRAMES * rhytid_rig_vertices(rig) * 3 * sizeof(float);
    float *alone = malloc(bytes);
    int count = 0;
    evaluate(alone, &count);
    pthread_t threads[2];
    for (size_t i = 0; i < 2; i++) of_thread[i] = malloc(bytes);
    for (size_t i = 0; i < 2; i++) CHECK(pthread_create(&threads[i], NULL, run, (void *)i) == 0);
    for (size_t i = 0; i < 2; i++) CHECK(pthread_join(threads[i], NULL) == 0);
    for (size_t i = 0; i < 2; i++) {
        CHECK(submitted[i] == FRAMES && memcmp(alone, of_thread[i], bytes) == 0);
        free(of_thread[i]);
    }
    free(alone);
    rhytid_vulkan_free(vulkan);
    rhytid_take_free(take);
    rhytid_rig_free(rig);
    destroy(own);
    puts("the queue is shared");
    return 0;
}
