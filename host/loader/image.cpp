/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/image.h"

#include <tiny_gltf.h>

#include <climits>
#include <cstdlib>
#include <cstring>
#include <exception>

namespace {

/* Zero for anything but a PNG, or a JPEG with a frame header. */
void read_size(const unsigned char *p, size_t size, size_t *width, size_t *height) {
    static const unsigned char png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    *width = *height = 0;
    if (size >= 24 && std::memcmp(p, png, sizeof png) == 0) {
        *width = static_cast<size_t>(p[16]) << 24 | p[17] << 16 | p[18] << 8 | p[19];
        *height = static_cast<size_t>(p[20]) << 24 | p[21] << 16 | p[22] << 8 | p[23];
    } else if (size >= 4 && p[0] == 0xff && p[1] == 0xd8) {
        size_t i = 2;
        while (i + 9 < size && p[i] == 0xff) {
            const unsigned marker = p[i + 1];
            if (marker == 0xff) {
                ++i; /* a fill byte */
            } else if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 &&
                       marker != 0xcc) {
                *height = p[i + 5] << 8 | p[i + 6];
                *width = p[i + 7] << 8 | p[i + 8];
                return;
            } else {
                i += 2 + (p[i + 2] << 8 | p[i + 3]);
            }
        }
    }
}

/* 16-bit pixels, which tinygltf stores in the machine's order, to 8 bits. */
void narrow(tinygltf::Image *image) {
    const size_t samples = image->image.size() / 2;
    for (size_t i = 0; i < samples; ++i) {
        uint16_t wide;
        std::memcpy(&wide, image->image.data() + 2 * i, sizeof wide);
        image->image[i] = static_cast<unsigned char>((wide + 128u) / 257u);
    }
    image->image.resize(samples);
    image->bits = 8;
}

const char *decode(mcv_bytes file, mcv_gltf_picture *picture) {
    tinygltf::Image image;
    std::string err, warn;
    if (file.size > INT_MAX || !tinygltf::LoadImageData(&image, 0, &err, &warn, 0, 0, file.data,
                                                        static_cast<int>(file.size), nullptr))
        return "cannot be decoded";
    if ((image.bits != 8 && image.bits != 16) || image.component != 4)
        return "has an unknown pixel format";
    if (image.bits == 16) narrow(&image);
    if (image.width <= 0 || image.height <= 0 ||
        image.image.size() !=
            4 * static_cast<size_t>(image.width) * static_cast<size_t>(image.height))
        return "has no pixels";
    picture->rgba = static_cast<uint8_t *>(std::malloc(image.image.size()));
    if (!picture->rgba) throw std::bad_alloc();
    std::memcpy(picture->rgba, image.image.data(), image.image.size());
    picture->width = static_cast<uint32_t>(image.width);
    picture->height = static_cast<uint32_t>(image.height);
    return nullptr;
}

} // namespace

mcv_result mcv_image_size(mcv_bytes file, uint32_t *width, uint32_t *height,
                          const mcv_json_path *place, mcv_error *error) {
    const size_t limit = size_t{1} << 27; /* tinygltf counts the bytes of 16-bit RGBA in an int */
    size_t w, h;
    read_size(file.data, file.size, &w, &h);
    if (w == 0 || h == 0) return mcv_fail_at(place, error, "is neither a PNG nor a JPEG");
    if (w > limit / h) return mcv_fail_at(place, error, "has more than 2^27 pixels");
    *width = static_cast<uint32_t>(w);
    *height = static_cast<uint32_t>(h);
    return MCV_OK;
}

mcv_result mcv_image_decode(mcv_bytes file, mcv_gltf_picture *picture, const mcv_json_path *place,
                            mcv_error *error) {
    try {
        const char *wrong = decode(file, picture);
        return wrong ? mcv_fail_at(place, error, "%s", wrong) : MCV_OK;
    } catch (const std::bad_alloc &) {
        return mcv_fail_memory(place, error);
    } catch (const std::exception &exception) {
        return mcv_fail_at(place, error, "cannot be decoded: %s", exception.what());
    }
}
