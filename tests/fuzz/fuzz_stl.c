/* SPDX-License-Identifier: Apache-2.0 */
/* STL parts, ASCII and binary. */
#include "fuzz.h"

#include "core/input_file.h"
#include "loader/load_stl.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const mcv_json_path place = mcv_place_file("in.stl");
    mcv_scene *scene = mcv_scene_new("in.stl");
    mcv_error error = {""};
    uint32_t mesh;
    double extent[3];
    uint8_t *copy = malloc(size ? size : 1); /* its exact length */
    if (scene && copy) {
        memcpy(copy, data, size);
        fuzz_sentence(
            mcv_load_stl(scene, (mcv_bytes){copy, size}, "in", &mesh, extent, &place, &error),
            &error);
    }
    free(copy);
    mcv_scene_free(scene);
    return 0;
}
