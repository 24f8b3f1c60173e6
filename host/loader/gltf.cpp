/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/gltf.h"

#include <tiny_gltf.h>

#include <cstdlib>
#include <cstring>
#include <exception>

/* A callback's failure waits here, because tinygltf takes a missing image for a warning. */
struct reading {
    mcv_gltf_read *read;
    void *user;
    const mcv_json_path *place;
    mcv_error *error;
    mcv_result result;
};

struct mcv_gltf {
    tinygltf::Model model;
};

namespace {

bool file_exists(const std::string &, void *) { return true; }

std::string same_path(const std::string &path, void *) { return path; }

bool read_file(std::vector<unsigned char> *out, std::string *, const std::string &uri, void *user) {
    auto *state = static_cast<reading *>(user);
    mcv_bytes bytes = {nullptr, 0};
    state->result = state->read(state->user, uri.c_str(), &bytes, state->error);
    if (state->result != MCV_OK) return false;
    try {
        out->assign(bytes.data, bytes.data + bytes.size);
    } catch (...) {
        std::free(bytes.data);
        throw;
    }
    std::free(bytes.data);
    return true;
}

/* Size of a PNG, or of a JPEG by its frame header; zero for anything else. Asked before anything is
 * allocated for pixels. */
void image_size(const unsigned char *p, size_t size, size_t *width, size_t *height) {
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

bool load_image(tinygltf::Image *image, const int index, std::string *err, std::string *warn, int,
                int, const unsigned char *bytes, int size, void *user) {
    auto *state = static_cast<reading *>(user);
    const size_t limit = size_t{1} << 27; /* tinygltf counts the bytes of 16-bit RGBA in an int */
    size_t width, height;
    image_size(bytes, size < 0 ? 0 : static_cast<size_t>(size), &width, &height);
    const char *wrong = nullptr;
    if (width == 0 || height == 0)
        wrong = "is neither a PNG nor a JPEG";
    else if (width > limit / height)
        wrong = "has more than 2^27 pixels";
    else if (!tinygltf::LoadImageData(image, index, err, warn, 0, 0, bytes, size, nullptr))
        wrong = "cannot be decoded";
    else if ((image->bits != 8 && image->bits != 16) || image->component != 4)
        wrong = "has an unknown pixel format";
    if (!wrong) return true;
    if (state->result == MCV_OK)
        state->result =
            mcv_fail_at(state->place, state->error, "%s %s", image->name.c_str(), wrong);
    return false;
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

mcv_result load(mcv_gltf *gltf, const char *json, size_t length, reading *state) {
    tinygltf::TinyGLTF loader;
    tinygltf::FsCallbacks callbacks = {file_exists, same_path, read_file, nullptr, state};
    std::string err, warn;
    loader.SetFsCallbacks(callbacks);
    loader.SetImageLoader(load_image, state);
    const bool loaded = loader.LoadASCIIFromString(
        &gltf->model, &err, &warn, json, static_cast<unsigned>(length), "", tinygltf::NO_REQUIRE);
    if (state->result != MCV_OK) return state->result;
    if (!loaded) {
        for (char &c : err)
            if (c == '\n') c = ' ';
        return mcv_fail_at(state->place, state->error,
                           "its buffers or images cannot be read: %.512s", err.c_str());
    }
    for (auto &buffer : gltf->model.buffers)
        std::string().swap(buffer.uri); /* a data URI is as long as the data */
    for (auto &image : gltf->model.images) {
        if (image.bits == 16) narrow(&image);
        if (image.width <= 0 || image.height <= 0 ||
            image.image.size() !=
                4 * static_cast<size_t>(image.width) * static_cast<size_t>(image.height))
            return mcv_fail_at(state->place, state->error, "%s has no pixels", image.name.c_str());
    }
    return MCV_OK;
}

} // namespace

mcv_result mcv_gltf_open(const char *json, size_t length, mcv_gltf_read *read, void *user,
                         mcv_gltf **gltf, const mcv_json_path *place, mcv_error *error) {
    *gltf = nullptr;
    if (length > INT32_MAX)
        return mcv_fail_at(place, error,
                           "its data URIs exceed 2 GiB: put the data into a .bin or .glb file");
    try {
        reading state = {read, user, place, error, MCV_OK};
        *gltf = new mcv_gltf;
        const mcv_result result = load(*gltf, json, length, &state);
        if (result == MCV_OK) return MCV_OK;
        mcv_gltf_close(*gltf);
        *gltf = nullptr;
        return result;
    } catch (const std::bad_alloc &) {
        mcv_gltf_close(*gltf);
        *gltf = nullptr;
        return mcv_fail_memory(place, error);
    } catch (const std::exception &exception) {
        mcv_gltf_close(*gltf);
        *gltf = nullptr;
        return mcv_fail_at(place, error, "its buffers or images cannot be read: %s",
                           exception.what());
    }
}

void mcv_gltf_close(mcv_gltf *gltf) { delete gltf; }

mcv_bytes mcv_gltf_buffer(const mcv_gltf *gltf, size_t index) {
    const auto &data = gltf->model.buffers[index].data;
    return {const_cast<uint8_t *>(data.data()), data.size()};
}

const uint8_t *mcv_gltf_image(const mcv_gltf *gltf, size_t index, uint32_t *width,
                              uint32_t *height) {
    const tinygltf::Image &image = gltf->model.images[index];
    *width = static_cast<uint32_t>(image.width);
    *height = static_cast<uint32_t>(image.height);
    return image.image.data();
}
