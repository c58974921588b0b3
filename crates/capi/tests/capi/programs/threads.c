/* Two threads with an animator each and a rig in common give the bits of one thread; their errors do not mix. */
#include "check.h"
#include <pthread.h>

enum { FRAMES = 12 };

static RhytidRig *rig;
static RhytidTake *take;
static pthread_barrier_t barrier;

struct Work {
    const char *file;
    float *results;
};

static void evaluate(float *results) {
    RhytidAnimatorOptions options = rhytid_animator_options();
    options.device = "cpu:0";
    RhytidAnimator *animator;
    OK(rhytid_animator_new(rig, &options, &animator));
    size_t numbers = 3 * rhytid_rig_handles(rig), values = rhytid_animator_values(animator, RHYTID_STAGE_POSITIONS);
    for (size_t frame = 0; frame < FRAMES; frame++) {
        OK(rhytid_animator_evaluate(animator, rhytid_take_positions(take) + frame * numbers, numbers));
        OK(rhytid_animator_read(animator, RHYTID_STAGE_POSITIONS, results + frame * values, values));
    }
    rhytid_animator_free(animator);
}

static void *run(void *argument) {
    struct Work *work = argument;
    RhytidRig *none;
    CHECK(strcmp(rhytid_last_error(), "") == 0);
    /* Both fail, then both look at their own sentence. */
    CHECK(rhytid_rig_open(work->file, &none) == RHYTID_STATUS_IO);
    pthread_barrier_wait(&barrier);
    CHECK(strstr(rhytid_last_error(), work->file) == rhytid_last_error());
    evaluate(work->results);
    CHECK(strstr(rhytid_last_error(), work->file) == rhytid_last_error());
    return NULL;
}

int main(int words, char **word) {
    CHECK(words == 3);
    OK(rhytid_rig_open(word[1], &rig));
    OK(rhytid_take_open(word[2], rig, RHYTID_MISSING_ERROR, &take));
    size_t bytes = FRAMES * rhytid_rig_vertices(rig) * 3 * sizeof(float);
    struct Work work[2] = {{"one.safetensors", malloc(bytes)}, {"two.safetensors", malloc(bytes)}};
    float *alone = malloc(bytes);
    pthread_t threads[2];
    pthread_barrier_init(&barrier, NULL, 2);
    for (int i = 0; i < 2; i++) CHECK(pthread_create(&threads[i], NULL, run, &work[i]) == 0);
    for (int i = 0; i < 2; i++) CHECK(pthread_join(threads[i], NULL) == 0);
    CHECK(strcmp(rhytid_last_error(), "") == 0);
    evaluate(alone);
    for (int i = 0; i < 2; i++) {
        CHECK(memcmp(alone, work[i].results, bytes) == 0);
        free(work[i].results);
    }
    free(alone);
    pthread_barrier_destroy(&barrier);
    rhytid_take_free(take);
    rhytid_rig_free(rig);
    puts("threads do not disturb each other");
    return 0;
}
