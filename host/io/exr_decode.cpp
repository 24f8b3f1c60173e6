/* SPDX-License-Identifier: Apache-2.0 */
#include "io/exr_decode.h"

#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfTiledInputPart.h>

#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

namespace {

/* A file in memory. */
class stream : public Imf::IStream {
  public:
    stream(const char *path, const uint8_t *bytes, size_t size)
        : Imf::IStream(path), bytes(reinterpret_cast<const char *>(bytes)), size(size) {}

    bool isMemoryMapped() const override { return false; }

    bool read(char c[], int n) override {
        if (n < 0 || static_cast<size_t>(n) > size - at)
            throw std::runtime_error("it ends too early");
        std::memcpy(c, bytes + at, static_cast<size_t>(n));
        at += static_cast<size_t>(n);
        return at < size;
    }

    uint64_t tellg() override { return at; }

    void seekg(uint64_t position) override {
        if (position > size) throw std::runtime_error("it points behind its end");
        at = position;
    }

  private:
    const char *bytes;
    size_t size, at = 0;
};

void decode_part(Imf::MultiPartInputFile &file, int index, const mcv_exr_part &part) {
    const Imath::Box2i window = file.header(index).dataWindow();
    const size_t width = part.image.width, height = part.image.height;
    Imf::FrameBuffer planes;
    for (uint32_t c = 0; c < part.image.channels; ++c)
        planes.insert(part.channel_names[c],
                      Imf::Slice::Make(Imf::FLOAT, part.image.pixels + c * width * height,
                                       window.min, static_cast<int64_t>(width),
                                       static_cast<int64_t>(height), sizeof(float),
                                       width * sizeof(float)));
    /* InputPart reads tiles, too, but keeps a row of them. */
    if (file.header(index).type() == "tiledimage") {
        Imf::TiledInputPart input(file, index);
        input.setFrameBuffer(planes);
        input.readTiles(0, input.numXTiles(0) - 1, 0, input.numYTiles(0) - 1);
    } else {
        Imf::InputPart input(file, index);
        input.setFrameBuffer(planes);
        input.readPixels(window.min.y, window.max.y);
    }
}

} // namespace

mcv_result mcv_exr_decode(const char *path, const uint8_t *bytes, size_t size, const mcv_exr *exr,
                          mcv_error *error) {
    try {
        stream in(path, bytes, size);
        Imf::MultiPartInputFile file(in, 0, false);
        if (file.parts() != static_cast<int>(exr->part_count))
            throw std::runtime_error("its parts cannot be told apart");
        for (uint32_t p = 0; p < exr->part_count; ++p)
            decode_part(file, static_cast<int>(p), exr->parts[p]);
        return MCV_OK;
    } catch (const std::bad_alloc &) {
        return mcv_fail(error, MCV_FAILED, "%s: no memory to decode it", path);
    } catch (const std::exception &exception) {
        return mcv_fail(error, MCV_BAD_INPUT, "%s: damaged OpenEXR file: %.512s", path,
                        exception.what());
    }
}
