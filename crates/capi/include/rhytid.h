// Rhytid's runtime for C: a rig from a file or from memory, devices, and frames in batches.
//
// This file is made from the sources of crates/capi. docs/c.md has examples and the rules: who frees what, and
// which thread may call what. Names of functions begin with rhytid_, of types with Rhytid, and of constants with
// RHYTID_.
//
// Every function that can fail returns a RhytidStatus, and rhytid_last_error() is the sentence that goes with
// it. Functions that tell a fact return 0 or NULL for a NULL pointer. No function throws or ends the process.

#ifndef RHYTID_H
#define RHYTID_H

#include <stddef.h>
#include <stdint.h>

// The version of the binary interface that this header describes. It rises if a function, a structure or the
// value of a constant changes or goes. It stays if something is only added. A program compares it with
// rhytid_abi_version(), which is the library's.
#define RHYTID_ABI_VERSION 1

// How many stages there are: the length of the array of rhytid_animator_stage_times().
#define RHYTID_STAGE_COUNT 6

// What became of a call. Each error also has a sentence for people: rhytid_last_error().
enum RhytidStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The call did what it should.
  RHYTID_STATUS_OK = 0,
  // An argument is null, an unknown value, or of a wrong length: a mistake of the calling program.
  RHYTID_STATUS_ARGUMENT = 1,
  // A file could not be opened or read.
  RHYTID_STATUS_IO = 2,
  // The work was stopped on request.
  RHYTID_STATUS_CANCELLED = 3,
  // A fault in Rhytid itself. Free the object of the call, and report the fault.
  RHYTID_STATUS_INTERNAL = 4,
  // This library was built without what the call needs.
  RHYTID_STATUS_LEFT_OUT = 5,
  // There is no such device.
  RHYTID_STATUS_DEVICE_NOT_FOUND = 100,
  // The device lacks a feature or a limit that the rig needs.
  RHYTID_STATUS_DEVICE_UNSUPPORTED = 101,
  // The device's memory does not suffice.
  RHYTID_STATUS_DEVICE_OUT_OF_MEMORY = 102,
  // The device was reset, unplugged or taken away. Free the animator, and make one on another device.
  RHYTID_STATUS_DEVICE_LOST = 103,
  // A kernel did not build.
  RHYTID_STATUS_DEVICE_BUILD = 104,
  // Any other error of the driver.
  RHYTID_STATUS_DEVICE_DRIVER = 105,
  // An input is wrong in a way that has no value of its own. The sentence says how.
  RHYTID_STATUS_INPUT_OTHER = 200,
  // A take has no columns for some of the rig's handles.
  RHYTID_STATUS_INPUT_MISSING_MARKERS = 201,
  // Something names handles or markers that are not there.
  RHYTID_STATUS_INPUT_UNKNOWN_MARKERS = 202,
  // Something names an example, a group, a region, a material or a property that is not there.
  RHYTID_STATUS_INPUT_UNKNOWN_NAME = 203,
  // A unit of length is unknown.
  RHYTID_STATUS_INPUT_UNKNOWN_UNIT = 204,
  // A file has an unknown key.
  RHYTID_STATUS_INPUT_UNKNOWN_KEY = 205,
  // A file lacks a key or a section.
  RHYTID_STATUS_INPUT_MISSING_KEY = 206,
  // A key of a file has a wrong value.
  RHYTID_STATUS_INPUT_WRONG_VALUE = 207,
  // A file breaks its format's rules.
  RHYTID_STATUS_INPUT_MALFORMED = 208,
  // A file ends too early, or has another length than it announces.
  RHYTID_STATUS_INPUT_CUT_SHORT = 209,
  // A rig's arrays do not fit together.
  RHYTID_STATUS_INPUT_RIG_DAMAGED = 210,
  // A file has a format that is not read.
  RHYTID_STATUS_INPUT_UNSUPPORTED_FORMAT = 211,
  // A file has a version of its format that is not read.
  RHYTID_STATUS_INPUT_UNSUPPORTED_VERSION = 212,
  // A number is outside what is allowed, such as a position that is not finite.
  RHYTID_STATUS_INPUT_OUT_OF_RANGE = 213,
  // Something is too large, such as a batch of more frames than the animator has room for.
  RHYTID_STATUS_INPUT_TOO_LARGE = 214,
  // Two things that belong together differ, such as a batch and the rig's number of handles.
  RHYTID_STATUS_INPUT_MISMATCH = 215,
  // A file that another file names does not exist.
  RHYTID_STATUS_INPUT_NOT_THERE = 216,
  // A file names another one outside its own folder.
  RHYTID_STATUS_INPUT_OUTSIDE_FOLDER = 217,
  // An output would overwrite an input.
  RHYTID_STATUS_INPUT_WOULD_OVERWRITE = 218,
  // A path leads to a folder, a device or nowhere.
  RHYTID_STATUS_INPUT_BAD_PATH = 219,
  // A take does not say how many frames a second has.
  RHYTID_STATUS_INPUT_NO_FRAME_RATE = 220,
  // A take lacks the position of a marker in some frames.
  RHYTID_STATUS_INPUT_MISSING_SAMPLES = 221,
  // A mesh is no surface that can be used.
  RHYTID_STATUS_INPUT_BAD_TOPOLOGY = 222,
  // There is nothing to work with, such as no batch that could be read.
  RHYTID_STATUS_INPUT_EMPTY = 223,
  // The rig lacks what was asked of it.
  RHYTID_STATUS_INPUT_RIG_LACKS = 224,
  // Two settings exclude each other.
  RHYTID_STATUS_INPUT_CONFLICT = 225,
  // Markers do not determine where they belong.
  RHYTID_STATUS_INPUT_NO_FIT = 226,
  // The equations have no solution in floating point.
  RHYTID_STATUS_INPUT_NOT_SOLVABLE = 227,
  // A network address cannot be used.
  RHYTID_STATUS_INPUT_NETWORK = 228,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum RhytidStatus RhytidStatus;
#else
typedef uint32_t RhytidStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The processor behind a device.
enum RhytidDeviceKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // A processor. Behind a GPU's API it is a software driver.
  RHYTID_DEVICE_KIND_CPU = 0,
  // A GPU that shares the processor's memory.
  RHYTID_DEVICE_KIND_INTEGRATED_GPU = 1,
  // A GPU with memory of its own.
  RHYTID_DEVICE_KIND_DISCRETE_GPU = 2,
  // A part of a GPU, given to a virtual machine.
  RHYTID_DEVICE_KIND_VIRTUAL_GPU = 3,
  // Anything else, or a device whose driver does not tell.
  RHYTID_DEVICE_KIND_OTHER = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum RhytidDeviceKind RhytidDeviceKind;
#else
typedef uint32_t RhytidDeviceKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// One result of the runtime, in the order in which they are computed. V is the number of vertices.
enum RhytidStage
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The ratios of the lengths of the strain edges: frames × strain edges.
  RHYTID_STAGE_STRAIN = 0,
  // The large-scale motion: frames × V × 3, mesh units.
  RHYTID_STAGE_LARGE_SCALE = 1,
  // The normals of the large-scale motion: frames × V × 3, of length 1, or 0 at a vertex without area.
  RHYTID_STAGE_LARGE_SCALE_NORMALS = 2,
  // The wrinkles alone, in tangent frames or along the axes of the mesh: frames × V × 3, mesh units.
  RHYTID_STAGE_DETAIL = 3,
  // The vertices: frames × V × 3, mesh units.
  RHYTID_STAGE_POSITIONS = 4,
  // The normals of the vertices, as RHYTID_STAGE_LARGE_SCALE_NORMALS.
  RHYTID_STAGE_NORMALS = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum RhytidStage RhytidStage;
#else
typedef uint32_t RhytidStage;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How a device keeps the basis, by far the largest part of a rig.
enum RhytidBasis
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // As the rig has it, in 32 bits. This is the default.
  RHYTID_BASIS_F32 = 0,
  // Rounded to 16 bits: half the memory. Markers are still met.
  RHYTID_BASIS_F16 = 1,
  // As factors of clusters of vertices: a third to an eighth of the memory. Markers are still met.
  RHYTID_BASIS_CLUSTERED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum RhytidBasis RhytidBasis;
#else
typedef uint32_t RhytidBasis;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What is done where a marker is missing from a frame of a take: its cells are empty or no number.
enum RhytidMissing
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // It is an error, which names the frame and the marker. This is the default.
  RHYTID_MISSING_ERROR = 0,
  // The marker stays where it was last seen, or begins where it is first seen.
  RHYTID_MISSING_HOLD = 1,
  // Its positions are NaN. Your program fills them before it evaluates the frame.
  RHYTID_MISSING_LEAVE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum RhytidMissing RhytidMissing;
#else
typedef uint32_t RhytidMissing;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A rig on a device, and the results of the last batch. One thread at a time uses it, and any thread may.
// Threads that evaluate at the same time have an animator each.
typedef struct RhytidAnimator RhytidAnimator;

// The devices that were there when the list was made. It never changes, so any number of threads may use it.
typedef struct RhytidDevices RhytidDevices;

// A solved face. It never changes, so any number of threads may use it at the same time. Animators keep what
// they need of it: it may be freed before them.
typedef struct RhytidRig RhytidRig;

// The positions of a rig's handles over time. It never changes, so any number of threads may use it at the
// same time. It keeps nothing of the rig.
typedef struct RhytidTake RhytidTake;

// A renderer's device. Any number of threads may use it at the same time.
typedef struct RhytidVulkan RhytidVulkan;

// How an animator is made. rhytid_animator_options() gives the defaults, which a program then changes.
typedef struct RhytidAnimatorOptions {
  // A device such as "vulkan:0", or a backend such as "wgpu" for its first device. NULL for the first GPU,
  // or for the processor if there is none. The text is read during the call alone.
  const char *device;
  // The most frames of a batch, at least 1. The animator has memory for so many. By default 1.
  size_t max_frames;
  // How the device keeps the basis: a RhytidBasis. By default RHYTID_BASIS_F32.
  uint32_t basis;
} RhytidAnimatorOptions;

// A function of any type, as vkGetInstanceProcAddr returns it.
typedef void (*RhytidFunction)(void);

// vkGetInstanceProcAddr, with VkInstance as a pointer.
typedef RhytidFunction (*RhytidGetInstanceProcAddr)(void *instance, const char *name);

// The objects of Vulkan that a renderer lends. They are Vulkan 1.1 or later, belong together, and outlive
// the RhytidVulkan and every animator made with it. Rhytid destroys none of them. No feature or extension of
// the device is needed.
typedef struct RhytidVulkanHost {
  // vkGetInstanceProcAddr, cast to this type.
  RhytidGetInstanceProcAddr get_instance_proc_addr;
  // The VkInstance.
  void *instance;
  // The VkPhysicalDevice, of the instance.
  void *physical_device;
  // The VkDevice, made from the physical device.
  void *device;
  // A VkQueue of the device.
  void *queue;
  // The queue's family, which supports compute.
  uint32_t queue_family;
} RhytidVulkanHost;

// Where consecutive frames of a stage are on the device.
typedef struct RhytidVulkanSlice {
  // The VkBuffer: floats without padding, from offset 0. It can be a vertex buffer, a storage buffer and
  // the source of a copy. It belongs to the animator, and to the family of the queue.
  uint64_t buffer;
  // The first frame in it, counted from the first of the batch.
  size_t first_frame;
  // How many frames are in it.
  size_t frames;
} RhytidVulkanSlice;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version of the binary interface of the library that is loaded: RHYTID_ABI_VERSION of its own header.
uint32_t rhytid_abi_version(void);

// The version of the library, such as "0.1.0".
const char *rhytid_version(void);

// The sentence of the last call on this thread that failed: what was found, what was expected, what to do.
// It is UTF-8, and empty if no call has failed. A call that succeeds keeps it. It stays valid until the next
// call on this thread that fails. Other threads have their own.
const char *rhytid_last_error(void);

// Reads a rig file (.safetensors): a solved face.
//
// path is UTF-8 (on Unix any bytes). *rig becomes the rig, to be freed by rhytid_rig_free(), or NULL after
// an error: RHYTID_STATUS_IO, or RHYTID_STATUS_INPUT_… if the file is no rig or a damaged one.
RhytidStatus rhytid_rig_open(const char *path, struct RhytidRig **rig);

// As rhytid_rig_open(), from the bytes of a rig file. The bytes may be freed or changed after the call.
RhytidStatus rhytid_rig_from_memory(const uint8_t *bytes, size_t length, struct RhytidRig **rig);

// Frees a rig. NULL is ignored.
void rhytid_rig_free(struct RhytidRig *rig);

// V, the number of vertices. 0 for NULL.
size_t rhytid_rig_vertices(const struct RhytidRig *rig);

// H, the number of handles: the markers that a frame gives. 0 for NULL.
size_t rhytid_rig_handles(const struct RhytidRig *rig);

// The number of triangles. 0 for NULL.
size_t rhytid_rig_triangles(const struct RhytidRig *rig);

// The metres in one mesh unit, such as 0.01 for centimetres. 0 for NULL.
double rhytid_rig_metres_per_unit(const struct RhytidRig *rig);

// The rest positions of the vertices, V × 3, in mesh units. The memory is the rig's. NULL for NULL.
const float *rhytid_rig_rest(const struct RhytidRig *rig);

// The vertices of the triangles, triangles × 3, an index buffer. The memory is the rig's. NULL for NULL.
const uint32_t *rhytid_rig_triangle_vertices(const struct RhytidRig *rig);

// The texture coordinates of the corners of the triangles, triangles × 3 × 2, with (0, 0) at the lower left.
// They are of corners because a vertex at a seam of the texture has several. The memory is the rig's. NULL
// if the mesh has none, and for NULL.
const float *rhytid_rig_triangle_uvs(const struct RhytidRig *rig);

// The rest positions of the handles, H × 3, in mesh units: a frame without motion. The memory is the rig's.
// NULL for NULL.
const float *rhytid_rig_handle_rest(const struct RhytidRig *rig);

// The label of a handle, as the take's columns name it. Handles count from 0, in the order in which frames
// give their positions. The memory is the rig's. NULL if there is no such handle, and for NULL.
const char *rhytid_rig_handle_label(const struct RhytidRig *rig, size_t handle);

// Reads a clean take (CSV) for a rig: columns time, LABEL_x, LABEL_y and LABEL_z, in seconds and mesh units.
// A raw take of a capture system has to be cleaned first.
//
// missing is a RhytidMissing. *take becomes the take, to be freed by rhytid_take_free(), or NULL after an
// error: RHYTID_STATUS_IO, RHYTID_STATUS_INPUT_…, or RHYTID_STATUS_LEFT_OUT.
RhytidStatus rhytid_take_open(const char *path,
                              const struct RhytidRig *rig,
                              uint32_t missing,
                              struct RhytidTake **take);

// As rhytid_take_open(), from the bytes of a take. The bytes may be freed or changed after the call.
RhytidStatus rhytid_take_from_memory(const uint8_t *bytes,
                                     size_t length,
                                     const struct RhytidRig *rig,
                                     uint32_t missing,
                                     struct RhytidTake **take);

// Frees a take. NULL is ignored.
void rhytid_take_free(struct RhytidTake *take);

// The number of frames. 0 for NULL.
size_t rhytid_take_frames(const struct RhytidTake *take);

// The time of each frame, in seconds, rising. The memory is the take's. NULL for NULL.
const double *rhytid_take_times(const struct RhytidTake *take);

// The positions of the handles, frames × H × 3, in the rig's order: what rhytid_animator_evaluate() takes.
// The memory is the take's. NULL for NULL.
const float *rhytid_take_positions(const struct RhytidTake *take);

// Looks for the devices of every backend that this library has. This asks the drivers, which can take a
// second. *devices becomes the list, to be freed by rhytid_devices_free().
RhytidStatus rhytid_devices_find(struct RhytidDevices **devices);

// Frees a list of devices. NULL is ignored.
void rhytid_devices_free(struct RhytidDevices *devices);

// How many devices there are. 0 for NULL.
size_t rhytid_devices_count(const struct RhytidDevices *devices);

// The id of a device, such as "vulkan:0": what RhytidAnimatorOptions takes. NULL if there is no such device.
const char *rhytid_devices_id(const struct RhytidDevices *devices, size_t index);

// The name of a device, as its driver gives it. NULL if there is no such device.
const char *rhytid_devices_name(const struct RhytidDevices *devices, size_t index);

// The name and version of a device's driver. NULL if there is no such device.
const char *rhytid_devices_driver(const struct RhytidDevices *devices, size_t index);

// What is behind a device. RHYTID_DEVICE_KIND_OTHER if there is no such device.
RhytidDeviceKind rhytid_devices_kind(const struct RhytidDevices *devices, size_t index);

// The bytes that rigs and results can occupy on a device. 0 if the driver does not tell, or if there is no
// such device.
uint64_t rhytid_devices_memory(const struct RhytidDevices *devices, size_t index);

// How many backends have no device. 0 for NULL.
size_t rhytid_devices_missing_count(const struct RhytidDevices *devices);

// A sentence that names a backend without a device, and says how to get one. NULL if there is no such
// backend.
const char *rhytid_devices_missing(const struct RhytidDevices *devices, size_t index);

// The options that rhytid_animator_new() takes for NULL.
struct RhytidAnimatorOptions rhytid_animator_options(void);

// Uploads a rig to a device. This takes a while; after it, only positions of handles go to the device.
//
// options may be NULL for the defaults. *animator becomes the animator, to be freed by
// rhytid_animator_free(), or NULL after an error.
//
// Errors: RHYTID_STATUS_DEVICE_… if there is no such device or the rig does not fit on it,
// RHYTID_STATUS_INPUT_… if the options do not fit the rig.
RhytidStatus rhytid_animator_new(const struct RhytidRig *rig,
                                 const struct RhytidAnimatorOptions *options,
                                 struct RhytidAnimator **animator);

// Frees an animator, after waiting for its device. NULL is ignored.
void rhytid_animator_free(struct RhytidAnimator *animator);

// The id of the animator's device, such as "vulkan:0". The memory is the animator's. NULL for NULL.
const char *rhytid_animator_device(const struct RhytidAnimator *animator);

// The numbers of one frame of a stage, a RhytidStage. A batch has so many for each of its frames. 0 if there
// is no such stage, and for NULL.
size_t rhytid_animator_values(const struct RhytidAnimator *animator, uint32_t stage);

// Evaluates a batch of frames. The results replace those of the last batch, and memory that was lent by
// rhytid_animator_map() is not valid any more.
//
// positions has count numbers: frames × H × 3, mesh units, in the order of rhytid_rig_handle_label(). It may
// be changed after the call. On a GPU the batch may still be running after the call.
//
// Errors: RHYTID_STATUS_INPUT_MISMATCH for a count that is no multiple of 3 H above 0,
// RHYTID_STATUS_INPUT_TOO_LARGE for too many frames, RHYTID_STATUS_INPUT_OUT_OF_RANGE for a number that is
// not finite, RHYTID_STATUS_DEVICE_… if the device fails. After the first three, the results of the last
// batch are kept.
RhytidStatus rhytid_animator_evaluate(struct RhytidAnimator *animator,
                                      const float *positions,
                                      size_t count);

// Waits for the last batch, and copies a stage of it, a RhytidStage, to numbers: frames ×
// rhytid_animator_values(). capacity says how many numbers have room there.
//
// Errors: RHYTID_STATUS_ARGUMENT if there is too little room, RHYTID_STATUS_INPUT_EMPTY if no batch was
// evaluated, RHYTID_STATUS_DEVICE_…. Then numbers are as they were.
RhytidStatus rhytid_animator_read(struct RhytidAnimator *animator,
                                  uint32_t stage,
                                  float *numbers,
                                  size_t capacity);

// Waits for the last batch, and lends a stage of it, a RhytidStage: *numbers becomes the address of frames ×
// rhytid_animator_values() numbers, and *count how many there are. No memory of the program is needed. The
// memory is the animator's, and valid until the next call with this animator other than of a fact. On the
// processor, strains, positions and normals are not copied. With Vulkan, the device writes into this memory.
// Other stages and backends are copied once.
//
// Errors: as rhytid_animator_read(). Then *numbers is NULL and *count is 0.
RhytidStatus rhytid_animator_map(struct RhytidAnimator *animator,
                                 uint32_t stage,
                                 const float **numbers,
                                 size_t *count);

// Waits for the last batch, and says how long the device computed on each stage of it: seconds has
// RHYTID_STAGE_COUNT places, in the order of RhytidStage. A stage that was computed together with another
// one has 0. Each is -1 where the device cannot measure.
//
// Errors: RHYTID_STATUS_INPUT_EMPTY if no batch was evaluated, RHYTID_STATUS_DEVICE_….
RhytidStatus rhytid_animator_stage_times(struct RhytidAnimator *animator, double *seconds);

// Uses a renderer's own device. *vulkan becomes the device, to be freed by rhytid_vulkan_free(); animators
// made with it may outlive it.
//
// Errors: RHYTID_STATUS_DEVICE_UNSUPPORTED if the device lacks something, RHYTID_STATUS_DEVICE_NOT_FOUND if
// it does not belong to the instance, RHYTID_STATUS_LEFT_OUT.
RhytidStatus rhytid_vulkan_new(const struct RhytidVulkanHost *host, struct RhytidVulkan **vulkan);

// Frees what rhytid_vulkan_new() made, but no object of the renderer. NULL is ignored.
void rhytid_vulkan_free(struct RhytidVulkan *vulkan);

// As rhytid_animator_new(), on a renderer's own device. The device of the options has to be NULL.
RhytidStatus rhytid_vulkan_animator(const struct RhytidVulkan *vulkan,
                                    const struct RhytidRig *rig,
                                    const struct RhytidAnimatorOptions *options,
                                    struct RhytidAnimator **animator);

// Calls call(user) while no other thread submits work to the renderer's queue: Rhytid holds its lock
// meanwhile. A renderer does all of its own submissions to that queue in such calls, if more than one thread
// uses the queue or its animators. call may not call Rhytid, throw an exception, or leave by longjmp.
RhytidStatus rhytid_vulkan_with_queue(const struct RhytidVulkan *vulkan,
                                      void (*call)(void *user),
                                      void *user);

// As rhytid_animator_evaluate(), with semaphores, for an animator of Vulkan. The batch starts after the
// semaphores of wait. Those of signal are signalled when the results are complete and visible to work that
// waits for them. If the renderer may still be reading the last results, it signals a semaphore of wait when
// it is done. Work that is submitted to the same queue after the call sees the results without a semaphore.
//
// Errors: as rhytid_animator_evaluate(); RHYTID_STATUS_ARGUMENT if the animator is of another backend.
RhytidStatus rhytid_vulkan_evaluate(struct RhytidAnimator *animator,
                                    const float *positions,
                                    size_t count,
                                    const uint64_t *wait,
                                    size_t wait_count,
                                    const uint64_t *signal,
                                    size_t signal_count);

// Where a stage of the last batch, a RhytidStage, is on the device: *count becomes the number of buffers,
// and the first capacity of them go to slices, in the order of their frames. Most rigs have one. slices may
// be NULL if capacity is 0. The next batch overwrites the contents, and the buffers stay the same.
//
// RHYTID_STAGE_LARGE_SCALE_NORMALS may be complete only when it has been read. All other stages are
// complete.
//
// Errors: RHYTID_STATUS_ARGUMENT if the animator is not one of Vulkan.
RhytidStatus rhytid_vulkan_results(struct RhytidAnimator *animator,
                                   uint32_t stage,
                                   struct RhytidVulkanSlice *slices,
                                   size_t capacity,
                                   size_t *count);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* RHYTID_H */
