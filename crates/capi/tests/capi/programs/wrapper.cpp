// The C++ wrapper: the same results as the functions of C, errors as exceptions, objects that move.
#include "check.h"
#include <rhytid.hpp>
#include <algorithm>
#include <type_traits>

static_assert(!std::is_copy_constructible<rhytid::Rig>::value, "a rig has one owner");
static_assert(std::is_nothrow_move_constructible<rhytid::Animator>::value, "animators move");

template <class Call> static RhytidStatus thrown(const char *word, Call call) {
    try {
        call();
    } catch (const rhytid::Error &error) {
        CHECK(std::string(error.what()).find(word) != std::string::npos);
        return error.status();
    }
    return RHYTID_STATUS_OK;
}

int main(int words, char **word) {
    CHECK(words == 3);
    rhytid::check_abi();
    CHECK(thrown("not-there", [] { rhytid::Rig::open("not-there.safetensors"); }) == RHYTID_STATUS_IO);
    rhytid::Rig first = rhytid::Rig::open(word[1]);
    const rhytid::Rig rig = std::move(first);
    const rhytid::Take take = rhytid::Take::open(word[2], rig, RHYTID_MISSING_HOLD);
    size_t length;
    unsigned char *bytes = contents(word[1], &length);
    CHECK(rhytid::Rig::from_memory(bytes, length).vertices() == rig.vertices());
    free(bytes);
    bytes = contents(word[2], &length);
    CHECK(rhytid::Take::from_memory(bytes, length, rig).frames() == take.frames());
    free(bytes);
    CHECK(rig.rest().size() == 3 * rig.vertices() && rig.handle_rest().size() == 3 * rig.handles());
    CHECK(rig.triangle_vertices().size() == 3 * rig.triangles() && !rig.handle_label(0).empty());
    CHECK(rig.triangle_uvs().empty() || rig.triangle_uvs().size() == 6 * rig.triangles());
    CHECK(take.times().size() == take.frames() && rig.metres_per_unit() > 0);

    rhytid::Options options;
    CHECK(options.max_frames == 1 && options.basis == RHYTID_BASIS_F32);
    options.device = "cpu:0";
    options.max_frames = 2;
    rhytid::Animator made(rig, options);
    rhytid::Animator animator = std::move(made);
    CHECK(animator.device() == "cpu:0");
    CHECK(thrown("no batch", [&] { animator.map(RHYTID_STAGE_POSITIONS); }) == RHYTID_STATUS_INPUT_EMPTY);
    animator.evaluate(take.positions().part(0, 2 * 3 * rig.handles()));
    std::vector<float> positions, one(animator.values(RHYTID_STAGE_POSITIONS));
    animator.read(RHYTID_STAGE_POSITIONS, positions);
    CHECK(positions.size() == 2 * one.size());
    animator.evaluate(take.frame(1));
    animator.read(RHYTID_STAGE_POSITIONS, rhytid::Span<float>(one));
    CHECK(std::equal(one.begin(), one.end(), positions.begin() + static_cast<std::ptrdiff_t>(one.size())));
    CHECK(animator.stage_times()[RHYTID_STAGE_POSITIONS] >= 0);
    CHECK(thrown("cpu:0", [&] { animator.results(RHYTID_STAGE_POSITIONS); }) == RHYTID_STATUS_ARGUMENT);
    CHECK(thrown("capacity", [&] { animator.read(RHYTID_STAGE_POSITIONS, rhytid::Span<float>(one.data(), 1)); }) ==
          RHYTID_STATUS_ARGUMENT);

    bool has_cpu = false;
    for (const rhytid::Device &device : rhytid::Devices::find().devices) has_cpu |= device.id == "cpu:0";
    CHECK(has_cpu);
    std::puts("the wrapper is the library");
    return 0;
}
