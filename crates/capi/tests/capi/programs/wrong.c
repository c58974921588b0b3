/* Wrong arguments are errors with a code and a sentence, and nothing is changed or lost by them. */
#include "check.h"
#include <math.h>
#include <stdint.h>

static void of_null(const RhytidRig *rig, RhytidAnimator *animator) {
    const RhytidStatus wrong = RHYTID_STATUS_ARGUMENT;
    RhytidRig *no_rig = (RhytidRig *)(uintptr_t)8;
    FAILS(wrong, "rig is null", rhytid_rig_open("face.safetensors", NULL));
    FAILS(wrong, "path is null", rhytid_rig_open(NULL, &no_rig));
    CHECK(no_rig == NULL);
    FAILS(wrong, "bytes is null", rhytid_rig_from_memory(NULL, 10, &no_rig));
    CHECK(rhytid_rig_from_memory(NULL, 0, &no_rig) == RHYTID_STATUS_INPUT_CUT_SHORT ||
          rhytid_rig_from_memory(NULL, 0, &no_rig) >= RHYTID_STATUS_INPUT_OTHER);
    CHECK(rhytid_rig_vertices(NULL) == 0 && rhytid_rig_handles(NULL) == 0 && rhytid_rig_triangles(NULL) == 0);
    CHECK(rhytid_rig_rest(NULL) == NULL && rhytid_rig_triangle_vertices(NULL) == NULL);
    CHECK(rhytid_rig_triangle_uvs(NULL) == NULL && rhytid_rig_handle_rest(NULL) == NULL);
    CHECK(rhytid_rig_handle_label(NULL, 0) == NULL && rhytid_rig_metres_per_unit(NULL) == 0);

    RhytidTake *take;
    FAILS(wrong, "rig is null", rhytid_take_open("take.csv", NULL, RHYTID_MISSING_ERROR, &take));
    FAILS(wrong, "take is null", rhytid_take_open("take.csv", rig, RHYTID_MISSING_ERROR, NULL));
    FAILS(wrong, "path is null", rhytid_take_open(NULL, rig, RHYTID_MISSING_ERROR, &take));
    CHECK(take == NULL && rhytid_take_frames(NULL) == 0);
    CHECK(rhytid_take_times(NULL) == NULL && rhytid_take_positions(NULL) == NULL);

    FAILS(wrong, "devices is null", rhytid_devices_find(NULL));
    CHECK(rhytid_devices_count(NULL) == 0 && rhytid_devices_id(NULL, 0) == NULL);
    CHECK(rhytid_devices_name(NULL, 0) == NULL && rhytid_devices_driver(NULL, 0) == NULL);
    CHECK(rhytid_devices_kind(NULL, 0) == RHYTID_DEVICE_KIND_OTHER && rhytid_devices_memory(NULL, 0) == 0);
    CHECK(rhytid_devices_missing_count(NULL) == 0 && rhytid_devices_missing(NULL, 0) == NULL);

    RhytidAnimator *none;
    float number = 0;
    const float *lent = &number;
    size_t count = 9;
    double seconds[RHYTID_STAGE_COUNT];
    FAILS(wrong, "rig is null", rhytid_animator_new(NULL, NULL, &none));
    FAILS(wrong, "animator is null", rhytid_animator_new(rig, NULL, NULL));
    FAILS(wrong, "animator is null", rhytid_animator_evaluate(NULL, &number, 1));
    FAILS(wrong, "positions is null", rhytid_animator_evaluate(animator, NULL, 3));
    FAILS(wrong, "animator is null", rhytid_animator_read(NULL, RHYTID_STAGE_POSITIONS, &number, 1));
    FAILS(wrong, "numbers is null", rhytid_animator_read(animator, RHYTID_STAGE_POSITIONS, NULL, 1));
    FAILS(wrong, "animator is null", rhytid_animator_map(NULL, RHYTID_STAGE_POSITIONS, &lent, &count));
    CHECK(lent == NULL && count == 0);
    FAILS(wrong, "count is null", rhytid_animator_map(animator, RHYTID_STAGE_POSITIONS, &lent, NULL));
    FAILS(wrong, "seconds is null", rhytid_animator_stage_times(animator, NULL));
    FAILS(wrong, "animator is null", rhytid_animator_stage_times(NULL, seconds));
    CHECK(rhytid_animator_values(NULL, RHYTID_STAGE_STRAIN) == 0 && rhytid_animator_device(NULL) == NULL);

    RhytidVulkan *vulkan;
    RhytidVulkanHost host;
    memset(&host, 0, sizeof host);
    FAILS(wrong, "host is null", rhytid_vulkan_new(NULL, &vulkan));
    FAILS(wrong, "get_instance_proc_addr", rhytid_vulkan_new(&host, &vulkan));
    CHECK(vulkan == NULL);
    FAILS(wrong, "vulkan is null", rhytid_vulkan_animator(NULL, rig, NULL, &none));
    FAILS(wrong, "vulkan is null", rhytid_vulkan_with_queue(NULL, NULL, NULL));
    FAILS(wrong, "animator is null", rhytid_vulkan_evaluate(NULL, &number, 1, NULL, 0, NULL, 0));
    FAILS(wrong, "animator is null", rhytid_vulkan_results(NULL, RHYTID_STAGE_POSITIONS, NULL, 0, &count));

    rhytid_rig_free(NULL);
    rhytid_take_free(NULL);
    rhytid_devices_free(NULL);
    rhytid_animator_free(NULL);
    rhytid_vulkan_free(NULL);
}

static void of_files(const char *rig_path, const RhytidRig *rig) {
    RhytidRig *none;
    RhytidTake *take;
    FAILS(RHYTID_STATUS_IO, "not-there", rhytid_rig_open("not-there.safetensors", &none));
    FAILS(RHYTID_STATUS_INPUT_BAD_PATH, "/", rhytid_rig_open("/", &none));
    FAILS(RHYTID_STATUS_IO, "not-there", rhytid_take_open("not-there.csv", rig, RHYTID_MISSING_ERROR, &take));
    FAILS(RHYTID_STATUS_ARGUMENT, "missing is 3", rhytid_take_open("a.csv", rig, 3, &take));

    size_t length;
    unsigned char *bytes = contents(rig_path, &length);
    RhytidStatus status = rhytid_rig_from_memory(bytes, length - 5, &none);
    CHECK(status >= RHYTID_STATUS_INPUT_OTHER && none == NULL);
    CHECK(strstr(rhytid_last_error(), "memory") != NULL);
    status = rhytid_rig_from_memory((const unsigned char *)"rubbish", 7, &none);
    CHECK(status >= RHYTID_STATUS_INPUT_OTHER && none == NULL);
    free(bytes);

    const char *lacks = "time,nobody_x,nobody_y,nobody_z\n0,1,2,3\n";
    FAILS(RHYTID_STATUS_INPUT_MISSING_MARKERS, "handles are missing",
          rhytid_take_from_memory((const unsigned char *)lacks, strlen(lacks), rig, RHYTID_MISSING_ERROR, &take));
    CHECK(take == NULL);
}

static void of_numbers(const RhytidRig *rig, RhytidAnimator *animator) {
    size_t numbers = 3 * rhytid_rig_handles(rig);
    float *frame = malloc(3 * numbers * sizeof *frame);
    for (size_t i = 0; i < 3; i++) memcpy(frame + i * numbers, rhytid_rig_handle_rest(rig), numbers * sizeof *frame);
    size_t values = rhytid_animator_values(animator, RHYTID_STAGE_POSITIONS);
    float *positions = malloc(2 * values * sizeof *positions);
    CHECK(values == 3 * rhytid_rig_vertices(rig));

    FAILS(RHYTID_STATUS_INPUT_EMPTY, "no batch",
          rhytid_animator_read(animator, RHYTID_STAGE_POSITIONS, positions, 2 * values));
    OK(rhytid_animator_evaluate(animator, frame, numbers));
    OK(rhytid_animator_read(animator, RHYTID_STAGE_POSITIONS, positions, values));

    /* After each of these, the results of the last batch are kept. */
    FAILS(RHYTID_STATUS_INPUT_MISMATCH, "multiple", rhytid_animator_evaluate(animator, frame, 0));
    FAILS(RHYTID_STATUS_INPUT_MISMATCH, "multiple", rhytid_animator_evaluate(animator, frame, numbers - 1));
    FAILS(RHYTID_STATUS_INPUT_TOO_LARGE, "at most 2", rhytid_animator_evaluate(animator, frame, 3 * numbers));
    frame[4] = NAN;
    FAILS(RHYTID_STATUS_INPUT_OUT_OF_RANGE, "handle 1", rhytid_animator_evaluate(animator, frame, numbers));
    frame[4] = INFINITY;
    FAILS(RHYTID_STATUS_INPUT_OUT_OF_RANGE, "finite", rhytid_animator_evaluate(animator, frame, numbers));
    FAILS(RHYTID_STATUS_ARGUMENT, "odd address",
          rhytid_animator_evaluate(animator, (const float *)((const char *)frame + 1), numbers));
    FAILS(RHYTID_STATUS_ARGUMENT, "no memory holds", rhytid_animator_evaluate(animator, frame, SIZE_MAX / 2));

    float *again = malloc(values * sizeof *again);
    for (size_t i = 0; i < values; i++) again[i] = 7;
    FAILS(RHYTID_STATUS_ARGUMENT, "capacity is",
          rhytid_animator_read(animator, RHYTID_STAGE_POSITIONS, again, values - 1));
    FAILS(RHYTID_STATUS_ARGUMENT, "stage is 6", rhytid_animator_read(animator, 6, again, values));
    FAILS(RHYTID_STATUS_ARGUMENT, "stage is 4294967295", rhytid_animator_read(animator, UINT32_MAX, again, values));
    CHECK(again[0] == 7 && again[values - 1] == 7);
    CHECK(rhytid_animator_values(animator, 6) == 0);
    OK(rhytid_animator_read(animator, RHYTID_STAGE_POSITIONS, again, values));
    CHECK(memcmp(again, positions, values * sizeof *again) == 0);
    free(again);
    free(positions);
    free(frame);
}

static void of_options(const RhytidRig *rig, RhytidAnimator *on_cpu) {
    RhytidAnimator *none;
    RhytidAnimatorOptions options = rhytid_animator_options();
    CHECK(options.device == NULL && options.max_frames == 1 && options.basis == RHYTID_BASIS_F32);
    options.device = "cpu:7";
    FAILS(RHYTID_STATUS_DEVICE_NOT_FOUND, "cpu:0", rhytid_animator_new(rig, &options, &none));
    options.device = "abacus";
    FAILS(RHYTID_STATUS_DEVICE_NOT_FOUND, "abacus", rhytid_animator_new(rig, &options, &none));
    options.device = "\xff";
    FAILS(RHYTID_STATUS_ARGUMENT, "UTF-8", rhytid_animator_new(rig, &options, &none));
    options.device = "cpu:0";
    options.max_frames = 0;
    FAILS(RHYTID_STATUS_INPUT_OUT_OF_RANGE, "at least 1", rhytid_animator_new(rig, &options, &none));
    options.max_frames = 1;
    options.basis = 3;
    FAILS(RHYTID_STATUS_ARGUMENT, "basis is 3", rhytid_animator_new(rig, &options, &none));
    CHECK(none == NULL);

    size_t count;
    float number = 0;
    FAILS(RHYTID_STATUS_ARGUMENT, "cpu:0",
          rhytid_vulkan_results(on_cpu, RHYTID_STAGE_POSITIONS, NULL, 0, &count));
    FAILS(RHYTID_STATUS_ARGUMENT, "cpu:0", rhytid_vulkan_evaluate(on_cpu, &number, 1, NULL, 0, NULL, 0));
}

int main(int words, char **word) {
    CHECK(words == 2);
    CHECK(rhytid_abi_version() == RHYTID_ABI_VERSION && strlen(rhytid_version()) > 0);
    CHECK(strcmp(rhytid_last_error(), "") == 0);
    RhytidRig *rig;
    OK(rhytid_rig_open(word[1], &rig));
    CHECK(rhytid_rig_handle_label(rig, rhytid_rig_handles(rig)) == NULL);
    RhytidAnimatorOptions options = rhytid_animator_options();
    options.device = "cpu";
    options.max_frames = 2;
    RhytidAnimator *animator;
    OK(rhytid_animator_new(rig, &options, &animator));
    CHECK(strcmp(rhytid_animator_device(animator), "cpu:0") == 0);
    of_null(rig, animator);
    of_files(word[1], rig);
    of_numbers(rig, animator);
    of_options(rig, animator);
    rhytid_animator_free(animator);
    rhytid_rig_free(rig);
    puts("wrong arguments are errors");
    return 0;
}
