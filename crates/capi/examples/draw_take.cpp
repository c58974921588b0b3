// Draws a frame of a take with a Vulkan device of its own: the vertices never leave the device. Writes a picture.
//
//     draw_take face.safetensors performance.csv 12 face.ppm
//
// A renderer has most of this already. What concerns Rhytid is in main() and in Picture::record().
#include <rhytid.hpp>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "face_frag.h"
#include "face_vert.h"

// Pixels on a side of the picture.
constexpr std::uint32_t SIZE = 768;

static void must(VkResult result, const char *what) {
    if (result != VK_SUCCESS) {
        throw std::runtime_error(std::string(what) + " failed: VkResult " + std::to_string(result));
    }
}

// The objects of a renderer: a device with a queue that draws and computes.
struct Renderer {
    VkInstance instance{};
    VkPhysicalDevice physical{};
    VkDevice device{};
    VkQueue queue{};
    std::uint32_t family = 0;
    VkPhysicalDeviceMemoryProperties memory{};

    Renderer() {
        VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
        application.apiVersion = VK_API_VERSION_1_1;
        VkInstanceCreateInfo of_instance{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        of_instance.pApplicationInfo = &application;
        must(vkCreateInstance(&of_instance, nullptr, &instance), "making an instance");
        std::uint32_t count = 1;
        if (vkEnumeratePhysicalDevices(instance, &count, &physical) < 0 || count == 0) {
            throw std::runtime_error("there is no Vulkan device");
        }
        vkGetPhysicalDeviceMemoryProperties(physical, &memory);
        vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
        std::vector<VkQueueFamilyProperties> families(count);
        vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
        constexpr VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
        while (family < count && (families[family].queueFlags & wanted) != wanted) family++;
        if (family == count) throw std::runtime_error("no queue of the device both draws and computes");
        const float priority = 1;
        VkDeviceQueueCreateInfo of_queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
        of_queue.queueFamilyIndex = family;
        of_queue.queueCount = 1;
        of_queue.pQueuePriorities = &priority;
        VkDeviceCreateInfo of_device{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
        of_device.queueCreateInfoCount = 1;
        of_device.pQueueCreateInfos = &of_queue;
        must(vkCreateDevice(physical, &of_device, nullptr, &device), "opening the device");
        vkGetDeviceQueue(device, family, 0, &queue);
    }
    Renderer(const Renderer &) = delete;
    ~Renderer() {
        vkDestroyDevice(device, nullptr);
        vkDestroyInstance(instance, nullptr);
    }

    RhytidVulkanHost lend() const {
        return {reinterpret_cast<RhytidGetInstanceProcAddr>(vkGetInstanceProcAddr), instance, physical, device, queue,
                family};
    }

    VkDeviceMemory allocate(const VkMemoryRequirements &needs, VkMemoryPropertyFlags wanted) const {
        VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        info.allocationSize = needs.size;
        while (!(needs.memoryTypeBits & (1u << info.memoryTypeIndex)) ||
               (memory.memoryTypes[info.memoryTypeIndex].propertyFlags & wanted) != wanted) {
            if (++info.memoryTypeIndex == memory.memoryTypeCount) throw std::runtime_error("no memory of this kind");
        }
        VkDeviceMemory made;
        must(vkAllocateMemory(device, &info, nullptr, &made), "allocating memory");
        return made;
    }
};

// A buffer that the host sees.
struct Buffer {
    const Renderer &on;
    VkBuffer raw{};
    VkDeviceMemory memory{};
    void *mapped = nullptr;

    Buffer(const Renderer &on, VkDeviceSize bytes, VkBufferUsageFlags usage) : on(on) {
        VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
        info.size = bytes;
        info.usage = usage;
        must(vkCreateBuffer(on.device, &info, nullptr, &raw), "making a buffer");
        VkMemoryRequirements needs;
        vkGetBufferMemoryRequirements(on.device, raw, &needs);
        memory = on.allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
        must(vkBindBufferMemory(on.device, raw, memory, 0), "binding a buffer");
        must(vkMapMemory(on.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "mapping a buffer");
    }
    Buffer(const Buffer &) = delete;
    ~Buffer() {
        vkDestroyBuffer(on.device, raw, nullptr);
        vkFreeMemory(on.device, memory, nullptr);
    }
};

// A picture to draw into.
struct Image {
    const Renderer &on;
    VkImage raw{};
    VkDeviceMemory memory{};
    VkImageView view{};

    Image(const Renderer &on, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect) : on(on) {
        VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
        info.imageType = VK_IMAGE_TYPE_2D;
        info.format = format;
        info.extent = {SIZE, SIZE, 1};
        info.mipLevels = info.arrayLayers = 1;
        info.samples = VK_SAMPLE_COUNT_1_BIT;
        info.usage = usage;
        must(vkCreateImage(on.device, &info, nullptr, &raw), "making an image");
        VkMemoryRequirements needs;
        vkGetImageMemoryRequirements(on.device, raw, &needs);
        memory = on.allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
        must(vkBindImageMemory(on.device, raw, memory, 0), "binding an image");
        VkImageViewCreateInfo of_view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
        of_view.image = raw;
        of_view.viewType = VK_IMAGE_VIEW_TYPE_2D;
        of_view.format = format;
        of_view.subresourceRange = {aspect, 0, 1, 0, 1};
        must(vkCreateImageView(on.device, &of_view, nullptr, &view), "making a view");
    }
    Image(const Image &) = delete;
    ~Image() {
        vkDestroyImageView(on.device, view, nullptr);
        vkDestroyImage(on.device, raw, nullptr);
        vkFreeMemory(on.device, memory, nullptr);
    }
};

// The passes and pipelines that draw a face.
struct Picture {
    static constexpr VkFormat COLOR = VK_FORMAT_R8G8B8A8_SRGB, DEPTH = VK_FORMAT_D16_UNORM;
    const Renderer &on;
    Image color{on, COLOR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                VK_IMAGE_ASPECT_COLOR_BIT};
    Image depth{on, DEPTH, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT};
    Buffer pixels{on, SIZE * SIZE * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VkRenderPass pass{};
    VkFramebuffer framebuffer{};
    VkPipelineLayout layout{};
    VkPipeline pipeline{};
    VkCommandPool pool{};

    explicit Picture(const Renderer &on) : on(on) {
        make_pass();
        make_pipeline();
        VkCommandPoolCreateInfo of_pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        of_pool.queueFamilyIndex = on.family;
        must(vkCreateCommandPool(on.device, &of_pool, nullptr, &pool), "making a command pool");
    }
    Picture(const Picture &) = delete;
    ~Picture() {
        vkDestroyCommandPool(on.device, pool, nullptr);
        vkDestroyPipeline(on.device, pipeline, nullptr);
        vkDestroyPipelineLayout(on.device, layout, nullptr);
        vkDestroyFramebuffer(on.device, framebuffer, nullptr);
        vkDestroyRenderPass(on.device, pass, nullptr);
    }

    void make_pass() {
        VkAttachmentDescription attachments[2] = {};
        for (int i = 0; i < 2; i++) {
            attachments[i].format = i ? DEPTH : COLOR;
            attachments[i].samples = VK_SAMPLE_COUNT_1_BIT;
            attachments[i].loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
            attachments[i].storeOp = i ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE;
            attachments[i].finalLayout = i ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                           : VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        }
        VkAttachmentReference of_color{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        VkAttachmentReference of_depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
        VkSubpassDescription subpass{};
        subpass.colorAttachmentCount = 1;
        subpass.pColorAttachments = &of_color;
        subpass.pDepthStencilAttachment = &of_depth;
        // The copy to the host waits for the picture.
        VkSubpassDependency after{0, VK_SUBPASS_EXTERNAL, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                  VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                  VK_ACCESS_TRANSFER_READ_BIT, 0};
        VkRenderPassCreateInfo of_pass{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
        of_pass.attachmentCount = 2;
        of_pass.pAttachments = attachments;
        of_pass.subpassCount = 1;
        of_pass.pSubpasses = &subpass;
        of_pass.dependencyCount = 1;
        of_pass.pDependencies = &after;
        must(vkCreateRenderPass(on.device, &of_pass, nullptr, &pass), "making a render pass");
        const VkImageView views[] = {color.view, depth.view};
        VkFramebufferCreateInfo of_framebuffer{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
        of_framebuffer.renderPass = pass;
        of_framebuffer.attachmentCount = 2;
        of_framebuffer.pAttachments = views;
        of_framebuffer.width = of_framebuffer.height = SIZE;
        of_framebuffer.layers = 1;
        must(vkCreateFramebuffer(on.device, &of_framebuffer, nullptr, &framebuffer), "making a framebuffer");
    }

    void make_pipeline() {
        const VkPushConstantRange camera{VK_SHADER_STAGE_VERTEX_BIT, 0, 4 * sizeof(float)};
        VkPipelineLayoutCreateInfo of_layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        of_layout.pushConstantRangeCount = 1;
        of_layout.pPushConstantRanges = &camera;
        must(vkCreatePipelineLayout(on.device, &of_layout, nullptr, &layout), "making a layout");
        const auto module = [&](const std::uint32_t *words, std::size_t bytes) {
            VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
            info.codeSize = bytes;
            info.pCode = words;
            VkShaderModule made;
            must(vkCreateShaderModule(on.device, &info, nullptr, &made), "making a shader");
            return made;
        };
        VkPipelineShaderStageCreateInfo stages[2] = {};
        for (auto &stage : stages) {
            stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
            stage.pName = "main";
        }
        stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
        stages[0].module = module(face_vert, sizeof face_vert);
        stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
        stages[1].module = module(face_frag, sizeof face_frag);

        // Positions and normals as Rhytid writes them: three floats a vertex, nothing between.
        const VkVertexInputBindingDescription bindings[] = {{0, 12, VK_VERTEX_INPUT_RATE_VERTEX},
                                                            {1, 12, VK_VERTEX_INPUT_RATE_VERTEX}};
        const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                                {1, 1, VK_FORMAT_R32G32B32_SFLOAT, 0}};
        VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
        input.vertexBindingDescriptionCount = input.vertexAttributeDescriptionCount = 2;
        input.pVertexBindingDescriptions = bindings;
        input.pVertexAttributeDescriptions = attributes;
        VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
        assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
        const VkViewport viewport{0, 0, SIZE, SIZE, 0, 1};
        const VkRect2D scissor{{0, 0}, {SIZE, SIZE}};
        VkPipelineViewportStateCreateInfo of_viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
        of_viewport.viewportCount = of_viewport.scissorCount = 1;
        of_viewport.pViewports = &viewport;
        of_viewport.pScissors = &scissor;
        VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
        raster.lineWidth = 1;
        VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
        samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
        VkPipelineDepthStencilStateCreateInfo of_depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
        of_depth.depthTestEnable = of_depth.depthWriteEnable = VK_TRUE;
        of_depth.depthCompareOp = VK_COMPARE_OP_LESS;
        VkPipelineColorBlendAttachmentState written{};
        written.colorWriteMask = 0xf;
        VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
        blend.attachmentCount = 1;
        blend.pAttachments = &written;

        VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
        info.stageCount = 2;
        info.pStages = stages;
        info.pVertexInputState = &input;
        info.pInputAssemblyState = &assembly;
        info.pViewportState = &of_viewport;
        info.pRasterizationState = &raster;
        info.pMultisampleState = &samples;
        info.pDepthStencilState = &of_depth;
        info.pColorBlendState = &blend;
        info.layout = layout;
        info.renderPass = pass;
        must(vkCreateGraphicsPipelines(on.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "making a pipeline");
        for (const auto &stage : stages) vkDestroyShaderModule(on.device, stage.module, nullptr);
    }

    // Records the drawing of a face from Rhytid's buffers.
    VkCommandBuffer record(rhytid::Animator &animator, const Buffer &indices, std::size_t corners,
                           const float (&camera)[4]) const {
        VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        info.commandPool = pool;
        info.commandBufferCount = 1;
        VkCommandBuffer commands;
        must(vkAllocateCommandBuffers(on.device, &info, &commands), "making commands");
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        must(vkBeginCommandBuffer(commands, &begin), "recording");
        VkClearValue clear[2] = {};
        clear[0].color = {{0.02f, 0.02f, 0.03f, 1}};
        clear[1].depthStencil = {1, 0};
        VkRenderPassBeginInfo of_pass{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
        of_pass.renderPass = pass;
        of_pass.framebuffer = framebuffer;
        of_pass.renderArea = {{0, 0}, {SIZE, SIZE}};
        of_pass.clearValueCount = 2;
        of_pass.pClearValues = clear;
        vkCmdBeginRenderPass(commands, &of_pass, VK_SUBPASS_CONTENTS_INLINE);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
        vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof camera, camera);
        const VkBuffer results[] = {
            (VkBuffer)animator.results(RHYTID_STAGE_POSITIONS).at(0).buffer,
            (VkBuffer)animator.results(RHYTID_STAGE_NORMALS).at(0).buffer,
        };
        const VkDeviceSize offsets[] = {0, 0};
        vkCmdBindVertexBuffers(commands, 0, 2, results, offsets);
        vkCmdBindIndexBuffer(commands, indices.raw, 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(commands, static_cast<std::uint32_t>(corners), 1, 0, 0, 0);
        vkCmdEndRenderPass(commands);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {SIZE, SIZE, 1};
        vkCmdCopyImageToBuffer(commands, color.raw, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, pixels.raw, 1, &copy);
        must(vkEndCommandBuffer(commands), "recording");
        return commands;
    }
};

int main(int words, char **word) try {
    if (words != 5) {
        std::cerr << "usage: draw_take RIG TAKE FRAME PICTURE.ppm\n";
        return 2;
    }
    const rhytid::Rig rig = rhytid::Rig::open(word[1]);
    const rhytid::Take take = rhytid::Take::open(word[2], rig);
    const std::size_t frame = std::strtoul(word[3], nullptr, 10);

    // The renderer lends its device. It outlives the animator.
    const Renderer renderer;
    const Picture picture(renderer);
    const rhytid::Vulkan lent(renderer.lend());
    rhytid::Animator animator = lent.animator(rig);

    // The indices never change. The middle of the face at rest, and the scale that makes it fill the picture.
    const auto corners = rig.triangle_vertices();
    const Buffer indices(renderer, corners.size() * sizeof corners[0], VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    std::copy(corners.begin(), corners.end(), static_cast<std::uint32_t *>(indices.mapped));
    float camera[4] = {0, 0, 0, 0}, size = 0;
    for (std::size_t c = 0; c < 3; c++) {
        float low = rig.rest()[c], high = low;
        for (std::size_t i = c; i < rig.rest().size(); i += 3) {
            low = std::min(low, rig.rest()[i]);
            high = std::max(high, rig.rest()[i]);
        }
        camera[c] = (low + high) / 2;
        size = std::max(size, high - low);
    }
    camera[3] = 1.9f / size;

    // Once a frame: the batch signals, and the drawing waits for it on the device.
    VkSemaphoreCreateInfo of_semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkSemaphore evaluated;
    must(vkCreateSemaphore(renderer.device, &of_semaphore, nullptr, &evaluated), "making a semaphore");
    const std::vector<std::uint64_t> signal = {(std::uint64_t)evaluated};
    animator.evaluate(take.frame(frame), {}, signal);
    VkCommandBuffer commands = picture.record(animator, indices, corners.size(), camera);
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT;
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.waitSemaphoreCount = submit.commandBufferCount = 1;
    submit.pWaitSemaphores = &evaluated;
    submit.pWaitDstStageMask = &stage;
    submit.pCommandBuffers = &commands;
    lent.with_queue([&] { must(vkQueueSubmit(renderer.queue, 1, &submit, VK_NULL_HANDLE), "drawing"); });
    must(vkDeviceWaitIdle(renderer.device), "waiting for the picture");
    vkDestroySemaphore(renderer.device, evaluated, nullptr);

    std::ofstream file(word[4], std::ios::binary);
    file << "P6\n" << SIZE << " " << SIZE << "\n255\n";
    const char *pixels = static_cast<const char *>(picture.pixels.mapped);
    for (std::size_t i = 0; i < SIZE * SIZE; i++) file.write(pixels + 4 * i, 3);
    std::cout << word[4] << ": frame " << frame << " of " << rig.vertices() << " vertices\n";
    return file.flush() ? 0 : 1;
} catch (const std::exception &error) {
    std::cerr << "error: " << error.what() << "\n";
    return 1;
}
