/* A rig and a take from memory are those of the files; what is mapped is what is read; the rig may go first. */
#include "check.h"

static RhytidAnimator *animator(const RhytidRig *rig, size_t frames) {
    RhytidAnimatorOptions options = rhytid_animator_options();
    options.device = "cpu:0";
    options.max_frames = frames;
    RhytidAnimator *made;
    OK(rhytid_animator_new(rig, &options, &made));
    return made;
}

int main(int words, char **word) {
    CHECK(words == 3);
    RhytidRig *rig, *same_rig;
    RhytidTake *take, *same_take;
    size_t length;
    OK(rhytid_rig_open(word[1], &rig));
    OK(rhytid_take_open(word[2], rig, RHYTID_MISSING_ERROR, &take));
    unsigned char *bytes = contents(word[1], &length);
    OK(rhytid_rig_from_memory(bytes, length, &same_rig));
    memset(bytes, 0, length);
    free(bytes);
    bytes = contents(word[2], &length);
    OK(rhytid_take_from_memory(bytes, length, same_rig, RHYTID_MISSING_ERROR, &same_take));
    memset(bytes, 0, length);
    free(bytes);

    size_t handles = rhytid_rig_handles(rig), frames = rhytid_take_frames(take), batch = 9;
    CHECK(frames >= batch && rhytid_take_frames(same_take) == frames);
    const float *positions = rhytid_take_positions(take);
    CHECK(memcmp(positions, rhytid_take_positions(same_take), frames * handles * 3 * sizeof(float)) == 0);
    CHECK(memcmp(rhytid_take_times(take), rhytid_take_times(same_take), frames * sizeof(double)) == 0);
    CHECK(rhytid_take_times(take)[1] > rhytid_take_times(take)[0]);
    CHECK(strcmp(rhytid_rig_handle_label(rig, 0), rhytid_rig_handle_label(same_rig, 0)) == 0);
    const unsigned *corners = rhytid_rig_triangle_vertices(rig);
    for (size_t i = 0; i < 3 * rhytid_rig_triangles(rig); i++) CHECK(corners[i] < rhytid_rig_vertices(rig));
    CHECK(rhytid_rig_metres_per_unit(rig) > 0);

    RhytidAnimator *one = animator(rig, batch), *other = animator(same_rig, batch);
    rhytid_rig_free(rig);
    rhytid_rig_free(same_rig);
    size_t numbers = batch * handles * 3;
    OK(rhytid_animator_evaluate(one, positions, numbers));
    OK(rhytid_animator_evaluate(other, positions, numbers));
    for (uint32_t stage = 0; stage < RHYTID_STAGE_COUNT; stage++) {
        size_t expected = batch * rhytid_animator_values(one, stage), count;
        float *copy = malloc(expected * sizeof *copy + 1);
        const float *lent;
        OK(rhytid_animator_read(one, stage, copy, expected));
        OK(rhytid_animator_map(other, stage, &lent, &count));
        CHECK(count == expected && memcmp(copy, lent, expected * sizeof *copy) == 0);
        free(copy);
    }
    /* Strains, positions and normals are lent without a copy: the address is the same each time. */
    const float *first, *again;
    size_t count;
    OK(rhytid_animator_map(one, RHYTID_STAGE_POSITIONS, &first, &count));
    OK(rhytid_animator_evaluate(one, positions + handles * 3, handles * 3));
    OK(rhytid_animator_map(one, RHYTID_STAGE_POSITIONS, &again, &count));
    CHECK(first == again && count == rhytid_animator_values(one, RHYTID_STAGE_POSITIONS));

    double seconds[RHYTID_STAGE_COUNT], sum = 0;
    OK(rhytid_animator_stage_times(one, seconds));
    for (int i = 0; i < RHYTID_STAGE_COUNT; i++) sum += seconds[i];
    CHECK(sum > 0);

    rhytid_animator_free(one);
    rhytid_animator_free(other);
    rhytid_take_free(take);
    rhytid_take_free(same_take);
    puts("memory is the file");
    return 0;
}
