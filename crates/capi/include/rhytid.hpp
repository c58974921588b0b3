// Rhytid's runtime for C++17: rhytid.h with objects that free themselves, and errors as exceptions.
//
// Objects move and do not copy. An empty one, from which was moved, may only be destroyed or assigned to. Memory
// that an object lends is valid as rhytid.h says. Two threads may use the same Rig, Take or Vulkan, but not the
// same Animator.
#ifndef RHYTID_HPP
#define RHYTID_HPP

#include "rhytid.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace rhytid {

// What failed: what() is the sentence, and status() the code.
class Error : public std::runtime_error {
public:
    Error(RhytidStatus status, const char *sentence) : std::runtime_error(sentence), status_(status) {}
    RhytidStatus status() const noexcept { return status_; }

private:
    RhytidStatus status_;
};

// Throws if a function of rhytid.h has failed.
inline void check(RhytidStatus status) {
    if (status != RHYTID_STATUS_OK) throw Error(status, rhytid_last_error());
}

// The version of the library, such as "0.1.0".
inline std::string version() { return rhytid_version(); }

// Throws if the library that is loaded is not the one of this header. Every object checks this first.
inline void check_abi() {
    if (rhytid_abi_version() != RHYTID_ABI_VERSION) {
        throw std::runtime_error("the library of Rhytid has the binary interface " +
                                 std::to_string(rhytid_abi_version()) + ", this program was built for " +
                                 std::to_string(RHYTID_ABI_VERSION) + "; build it again");
    }
}

// Consecutive elements in memory of somebody else.
template <class T> class Span {
public:
    Span() = default;
    Span(T *data, std::size_t size) : data_(data), size_(size) {}
    template <class U> Span(std::vector<U> &from) : data_(from.data()), size_(from.size()) {}
    template <class U> Span(const std::vector<U> &from) : data_(from.data()), size_(from.size()) {}
    T *data() const { return data_; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    T *begin() const { return data_; }
    T *end() const { return data_ + size_; }
    T &operator[](std::size_t i) const { return data_[i]; }
    // The elements from `first` on: `count` of them.
    Span part(std::size_t first, std::size_t count) const {
        if (first > size_ || count > size_ - first) throw std::out_of_range("a part beyond the end of a span");
        return Span(data_ + first, count);
    }

private:
    T *data_ = nullptr;
    std::size_t size_ = 0;
};

namespace detail {
struct Free {
    void operator()(RhytidRig *rig) const { rhytid_rig_free(rig); }
    void operator()(RhytidTake *take) const { rhytid_take_free(take); }
    void operator()(RhytidDevices *devices) const { rhytid_devices_free(devices); }
    void operator()(RhytidAnimator *animator) const { rhytid_animator_free(animator); }
    void operator()(RhytidVulkan *vulkan) const { rhytid_vulkan_free(vulkan); }
};
template <class T> using Owned = std::unique_ptr<T, Free>;

// What `make` writes to the pointer that it gets.
template <class T, class Make> Owned<T> make(Make make) {
    check_abi();
    T *made = nullptr;
    check(make(&made));
    return Owned<T>(made);
}
} // namespace detail

// A solved face.
class Rig {
public:
    // Reads a rig file. `path` is UTF-8; on Unix any bytes.
    static Rig open(const std::string &path) {
        return Rig(detail::make<RhytidRig>([&](RhytidRig **rig) { return rhytid_rig_open(path.c_str(), rig); }));
    }
    static Rig from_memory(const void *bytes, std::size_t length) {
        const auto *first = static_cast<const std::uint8_t *>(bytes);
        return Rig(detail::make<RhytidRig>(
            [&](RhytidRig **rig) { return rhytid_rig_from_memory(first, length, rig); }));
    }

    std::size_t vertices() const { return rhytid_rig_vertices(get()); }
    std::size_t handles() const { return rhytid_rig_handles(get()); }
    std::size_t triangles() const { return rhytid_rig_triangles(get()); }
    double metres_per_unit() const { return rhytid_rig_metres_per_unit(get()); }
    // Vertices x 3.
    Span<const float> rest() const { return {rhytid_rig_rest(get()), 3 * vertices()}; }
    // Triangles x 3.
    Span<const std::uint32_t> triangle_vertices() const {
        return {rhytid_rig_triangle_vertices(get()), 3 * triangles()};
    }
    // Triangles x 3 x 2. Empty if the mesh has no texture coordinates.
    Span<const float> triangle_uvs() const {
        const float *uvs = rhytid_rig_triangle_uvs(get());
        return {uvs, uvs ? 6 * triangles() : 0};
    }
    // Handles x 3.
    Span<const float> handle_rest() const { return {rhytid_rig_handle_rest(get()), 3 * handles()}; }
    std::string handle_label(std::size_t handle) const {
        const char *label = rhytid_rig_handle_label(get(), handle);
        if (!label) throw std::out_of_range("the rig has no handle " + std::to_string(handle));
        return label;
    }
    const RhytidRig *get() const { return rig_.get(); }

private:
    explicit Rig(detail::Owned<RhytidRig> rig) : rig_(std::move(rig)) {}
    detail::Owned<RhytidRig> rig_;
};

// A clean take for a rig.
class Take {
public:
    static Take open(const std::string &path, const Rig &rig, RhytidMissing missing = RHYTID_MISSING_ERROR) {
        return Take(detail::make<RhytidTake>([&](RhytidTake **take) {
            return rhytid_take_open(path.c_str(), rig.get(), missing, take);
        }), rig);
    }
    static Take from_memory(const void *bytes, std::size_t length, const Rig &rig,
                            RhytidMissing missing = RHYTID_MISSING_ERROR) {
        const auto *first = static_cast<const std::uint8_t *>(bytes);
        return Take(detail::make<RhytidTake>([&](RhytidTake **take) {
            return rhytid_take_from_memory(first, length, rig.get(), missing, take);
        }), rig);
    }

    std::size_t frames() const { return rhytid_take_frames(take_.get()); }
    // The time of each frame, in seconds.
    Span<const double> times() const { return {rhytid_take_times(take_.get()), frames()}; }
    // Frames x handles x 3.
    Span<const float> positions() const { return {rhytid_take_positions(take_.get()), frames() * numbers_}; }
    // One frame: handles x 3.
    Span<const float> frame(std::size_t frame) const { return positions().part(frame * numbers_, numbers_); }
    const RhytidTake *get() const { return take_.get(); }

private:
    Take(detail::Owned<RhytidTake> take, const Rig &rig) : take_(std::move(take)), numbers_(3 * rig.handles()) {}
    detail::Owned<RhytidTake> take_;
    std::size_t numbers_;
};

struct Device {
    std::string id, name, driver;
    RhytidDeviceKind kind;
    std::uint64_t memory; // Bytes; 0 if the driver does not tell.
};

// The devices of this machine, and a sentence for each backend without one.
struct Devices {
    std::vector<Device> devices;
    std::vector<std::string> missing;

    static Devices find() {
        auto found = detail::make<RhytidDevices>([](RhytidDevices **made) { return rhytid_devices_find(made); });
        Devices all;
        for (std::size_t i = 0; i < rhytid_devices_count(found.get()); i++) {
            all.devices.push_back({rhytid_devices_id(found.get(), i), rhytid_devices_name(found.get(), i),
                                   rhytid_devices_driver(found.get(), i), rhytid_devices_kind(found.get(), i),
                                   rhytid_devices_memory(found.get(), i)});
        }
        for (std::size_t i = 0; i < rhytid_devices_missing_count(found.get()); i++) {
            all.missing.emplace_back(rhytid_devices_missing(found.get(), i));
        }
        return all;
    }
};

// How an animator is made. The defaults are the library's.
struct Options {
    std::string device; // Empty for the first GPU, or the processor.
    std::size_t max_frames = rhytid_animator_options().max_frames;
    std::uint32_t basis = rhytid_animator_options().basis;

    RhytidAnimatorOptions for_c() const { return {device.empty() ? nullptr : device.c_str(), max_frames, basis}; }
};

// A rig on a device.
class Animator {
public:
    explicit Animator(const Rig &rig, const Options &options = {})
        : animator_(detail::make<RhytidAnimator>([&](RhytidAnimator **made) {
              const RhytidAnimatorOptions for_c = options.for_c();
              return rhytid_animator_new(rig.get(), &for_c, made);
          })) {}

    std::string device() const { return rhytid_animator_device(animator_.get()); }
    // The numbers of one frame of a stage.
    std::size_t values(RhytidStage stage) const { return rhytid_animator_values(animator_.get(), stage); }

    // Evaluates frames x handles x 3 numbers.
    void evaluate(Span<const float> positions) {
        check(rhytid_animator_evaluate(animator_.get(), positions.data(), positions.size()));
    }
    // Copies a stage of the last batch, and makes room for it.
    void read(RhytidStage stage, std::vector<float> &numbers) {
        const Span<const float> lent = map(stage);
        numbers.assign(lent.begin(), lent.end());
    }
    // Copies a stage of the last batch to memory that has room for it.
    void read(RhytidStage stage, Span<float> numbers) {
        check(rhytid_animator_read(animator_.get(), stage, numbers.data(), numbers.size()));
    }
    // A stage of the last batch in the animator's memory, until the next call that is not const.
    Span<const float> map(RhytidStage stage) {
        const float *numbers = nullptr;
        std::size_t count = 0;
        check(rhytid_animator_map(animator_.get(), stage, &numbers, &count));
        return {numbers, count};
    }
    // Seconds on each stage, in the order of RhytidStage; -1 where the device cannot measure.
    std::array<double, RHYTID_STAGE_COUNT> stage_times() {
        std::array<double, RHYTID_STAGE_COUNT> seconds{};
        check(rhytid_animator_stage_times(animator_.get(), seconds.data()));
        return seconds;
    }

    // For an animator of Vulkan: evaluates after the semaphores of `wait`, and before those of `signal`.
    void evaluate(Span<const float> positions, Span<const std::uint64_t> wait, Span<const std::uint64_t> signal) {
        check(rhytid_vulkan_evaluate(animator_.get(), positions.data(), positions.size(), wait.data(), wait.size(),
                                     signal.data(), signal.size()));
    }
    // For an animator of Vulkan: the buffers of a stage of the last batch.
    std::vector<RhytidVulkanSlice> results(RhytidStage stage) {
        std::size_t count = 0;
        check(rhytid_vulkan_results(animator_.get(), stage, nullptr, 0, &count));
        std::vector<RhytidVulkanSlice> slices(count);
        check(rhytid_vulkan_results(animator_.get(), stage, slices.data(), slices.size(), &count));
        return slices;
    }
    RhytidAnimator *get() { return animator_.get(); }

private:
    friend class Vulkan;
    explicit Animator(detail::Owned<RhytidAnimator> animator) : animator_(std::move(animator)) {}
    detail::Owned<RhytidAnimator> animator_;
};

// A renderer's own Vulkan device.
class Vulkan {
public:
    explicit Vulkan(const RhytidVulkanHost &host)
        : vulkan_(detail::make<RhytidVulkan>([&](RhytidVulkan **made) { return rhytid_vulkan_new(&host, made); })) {}

    Animator animator(const Rig &rig, const Options &options = {}) const {
        const RhytidAnimatorOptions for_c = options.for_c();
        return Animator(detail::make<RhytidAnimator>([&](RhytidAnimator **made) {
            return rhytid_vulkan_animator(vulkan_.get(), rig.get(), &for_c, made);
        }));
    }
    // Calls `call` while nobody else submits to the queue. An exception of it is thrown afterwards.
    template <class Call> void with_queue(Call &&call) const {
        struct Held {
            Call &call;
            std::exception_ptr thrown;
        } held{call, nullptr};
        check(rhytid_vulkan_with_queue(
            vulkan_.get(),
            [](void *user) {
                Held &held = *static_cast<Held *>(user);
                try {
                    held.call();
                } catch (...) {
                    held.thrown = std::current_exception();
                }
            },
            &held));
        if (held.thrown) std::rethrow_exception(held.thrown);
    }
    const RhytidVulkan *get() const { return vulkan_.get(); }

private:
    detail::Owned<RhytidVulkan> vulkan_;
};

} // namespace rhytid

#endif // RHYTID_HPP
