/* SPDX-License-Identifier: Apache-2.0 */
/* Writes OpenEXR files of all kinds by the C++ library, and reads them by it. */
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <half.h>

#include <vector>

extern "C" void write_kind(const char *path, int width, int height, const float *rgb,
                           int compression, int is_half, int levels);
extern "C" void read_kind(const char *path, int width, int height, float *rgb);

static const char *const names[] = {"R", "G", "B"};

/* Where the data window begins. */
static const int left = 7, top = -5;

static Imf::FrameBuffer planes_of(float *rgb, int width, int height) {
    Imf::FrameBuffer planes;
    for (int k = 0; k < 3; ++k)
        planes.insert(names[k], Imf::Slice::Make(Imf::FLOAT, rgb + k * width * height,
                                                 Imath::V2i(left, top), width, height));
    return planes;
}

/* levels: -1 lines; 0 one level of tiles, 1 mipmap, 2 ripmap (only level 0 has these pixels). */
extern "C" void write_kind(const char *path, int width, int height, const float *rgb,
                           int compression, int is_half, int levels) {
    const Imath::Box2i window(Imath::V2i(left, top),
                              Imath::V2i(left + width - 1, top + height - 1));
    Imf::Header header(window, window);
    header.compression() = static_cast<Imf::Compression>(compression);
    std::vector<half> narrow(rgb, rgb + 3 * width * height);
    Imf::FrameBuffer planes;
    for (int k = 0; k < 3; ++k) {
        header.channels().insert(names[k], Imf::Channel(is_half ? Imf::HALF : Imf::FLOAT));
        planes.insert(names[k],
                      is_half ? Imf::Slice::Make(Imf::HALF, narrow.data() + k * width * height,
                                                 Imath::V2i(left, top), width, height)
                              : Imf::Slice::Make(Imf::FLOAT, rgb + k * width * height,
                                                 Imath::V2i(left, top), width, height));
    }
    if (levels < 0) {
        Imf::OutputFile file(path, header);
        file.setFrameBuffer(planes);
        file.writePixels(height);
        return;
    }
    header.setTileDescription(
        Imf::TileDescription(16, 24, static_cast<Imf::LevelMode>(levels), Imf::ROUND_UP));
    Imf::TiledOutputFile file(path, header);
    file.setFrameBuffer(planes);
    for (int y = 0; y < file.numYLevels(); ++y)
        for (int x = 0; x < file.numXLevels(); ++x)
            if (file.isValidLevel(x, y))
                file.writeTiles(0, file.numXTiles(x) - 1, 0, file.numYTiles(y) - 1, x, y);
}

extern "C" void read_kind(const char *path, int width, int height, float *rgb) {
    Imf::InputFile file(path);
    file.setFrameBuffer(planes_of(rgb, width, height));
    file.readPixels(top, top + height - 1);
}
