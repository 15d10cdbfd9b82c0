// Reads a deep OpenEXR file with OpenEXR's own library and writes what it holds: width and height, the samples of each
// pixel, all samples of channels A, B, G, R and Z in turn, and the picture that CompositeDeepScanLine makes of them (R,
// G, B, A of each pixel).
//
//   read_deep in.exr out.bin

#include <ImfChannelList.h>
#include <ImfCompositeDeepScanLine.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>

#include <cstdint>
#include <cstdio>
#include <exception>
#include <vector>

using namespace OPENEXR_IMF_NAMESPACE;

namespace {

const char* const CHANNELS[] = {"A", "B", "G", "R", "Z"};

template <class T> void put(std::FILE* out, const std::vector<T>& values) {
    if (std::fwrite(values.data(), sizeof(T), values.size(), out) != values.size()) {
        throw std::runtime_error("cannot write");
    }
}

void samples(const char* path, std::FILE* out) {
    DeepScanLineInputFile file(path);
    const auto window = file.header().dataWindow();
    const size_t width = window.max.x - window.min.x + 1;
    const size_t height = window.max.y - window.min.y + 1;
    std::vector<uint32_t> counts(width * height);
    std::vector<std::vector<float*>> pointers(5, std::vector<float*>(width * height));

    DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(
        Slice(UINT, reinterpret_cast<char*>(counts.data()), sizeof(uint32_t), sizeof(uint32_t) * width));
    for (size_t channel = 0; channel < 5; ++channel) {
        buffer.insert(
            CHANNELS[channel],
            DeepSlice(
                FLOAT, reinterpret_cast<char*>(pointers[channel].data()), sizeof(float*), sizeof(float*) * width,
                sizeof(float)));
    }
    file.setFrameBuffer(buffer);
    file.readPixelSampleCounts(window.min.y, window.max.y);
    size_t total = 0;
    for (uint32_t count : counts) {
        total += count;
    }
    std::vector<std::vector<float>> values(5, std::vector<float>(total));
    for (size_t channel = 0; channel < 5; ++channel) {
        float* next = values[channel].data();
        for (size_t pixel = 0; pixel < counts.size(); ++pixel) {
            pointers[channel][pixel] = next;
            next += counts[pixel];
        }
    }
    file.readPixels(window.min.y, window.max.y);
    put(out, std::vector<uint32_t>{uint32_t(width), uint32_t(height)});
    put(out, counts);
    for (const auto& channel : values) {
        put(out, channel);
    }
}

void flattened(const char* path, std::FILE* out) {
    DeepScanLineInputFile file(path);
    const auto window = file.header().dataWindow();
    const size_t width = window.max.x - window.min.x + 1;
    const size_t height = window.max.y - window.min.y + 1;
    std::vector<float> pixels(4 * width * height);
    FrameBuffer buffer;
    const char* const names[] = {"R", "G", "B", "A"};
    for (size_t channel = 0; channel < 4; ++channel) {
        char* base = reinterpret_cast<char*>(pixels.data() + channel);
        buffer.insert(names[channel], Slice(FLOAT, base, 4 * sizeof(float), 4 * sizeof(float) * width));
    }
    CompositeDeepScanLine composite;
    composite.addSource(&file);
    composite.setFrameBuffer(buffer);
    composite.readPixels(window.min.y, window.max.y);
    put(out, pixels);
}

} // namespace

int main(int count, char** arguments) {
    if (count != 3) {
        std::fprintf(stderr, "usage: read_deep in.exr out.bin\n");
        return 2;
    }
    std::FILE* out = std::fopen(arguments[2], "wb");
    if (out == nullptr) {
        std::perror(arguments[2]);
        return 1;
    }
    try {
        samples(arguments[1], out);
        flattened(arguments[1], out);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", arguments[1], error.what());
        return 1;
    }
    return std::fclose(out) == 0 ? 0 : 1;
}
