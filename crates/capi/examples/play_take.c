/* Plays a take: reads a rig and a take, evaluates frame after frame, and says how far the face moves.
 *
 *     cc play_take.c $(pkg-config --cflags --libs rhytid) -o play_take
 *     ./play_take face.safetensors performance.csv [frames.raw]
 *
 * With a third name, it writes the vertices of every frame there: frames x vertices x 3 floats. */
#include <rhytid.h>
#include <stdio.h>
#include <stdlib.h>

static void check(RhytidStatus status) {
    if (status != RHYTID_STATUS_OK) {
        fprintf(stderr, "error %d: %s\n", (int)status, rhytid_last_error());
        exit(1);
    }
}

int main(int words, char **word) {
    if (words < 3 || words > 4 || rhytid_abi_version() != RHYTID_ABI_VERSION) {
        fprintf(stderr, "usage: play_take RIG TAKE [FRAMES], with the library of this header\n");
        return 2;
    }
    RhytidRig *rig;
    RhytidTake *take;
    check(rhytid_rig_open(word[1], &rig));
    check(rhytid_take_open(word[2], rig, RHYTID_MISSING_HOLD, &take));

    RhytidAnimatorOptions options = rhytid_animator_options();
    options.device = getenv("RHYTID_DEVICE"); /* "cpu:0", "vulkan", ...; NULL is the first GPU. */
    RhytidAnimator *animator;
    check(rhytid_animator_new(rig, &options, &animator));

    const float *handles = rhytid_take_positions(take);
    const float *rest = rhytid_rig_rest(rig);
    size_t frames = rhytid_take_frames(take), numbers = 3 * rhytid_rig_handles(rig);
    FILE *file = words == 4 ? fopen(word[3], "wb") : NULL;
    float farthest = 0;
    for (size_t frame = 0; frame < frames; frame++) {
        check(rhytid_animator_evaluate(animator, handles + frame * numbers, numbers));
        const float *positions;
        size_t count;
        check(rhytid_animator_map(animator, RHYTID_STAGE_POSITIONS, &positions, &count));
        for (size_t i = 0; i < count; i++) {
            float moved = positions[i] > rest[i] ? positions[i] - rest[i] : rest[i] - positions[i];
            farthest = moved > farthest ? moved : farthest;
        }
        if (file && fwrite(positions, sizeof(float), count, file) != count) return 1;
    }
    printf("%zu frames of %zu vertices on %s: a coordinate moves by %g at most\n", frames,
           rhytid_rig_vertices(rig), rhytid_animator_device(animator), farthest);

    if (file) fclose(file);
    rhytid_animator_free(animator);
    rhytid_take_free(take);
    rhytid_rig_free(rig);
    return 0;
}
