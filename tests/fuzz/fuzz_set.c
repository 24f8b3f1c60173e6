/* SPDX-License-Identifier: Apache-2.0 */
/* --set PATH=VALUE, on a scene with all kinds of elements. */
#include "fuzz.h"

#include "loader/load.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static mcv_document document;
    mcv_error error = {""};
    mcv_scene *scene;
    if (!document.root && mcv_document_read(MCV_SOURCE_DIR "/scenes/structured-light.gltf",
                                            &document, &error) != MCV_OK)
        abort();
    char *text = calloc(1, size + 1);
    if (!text) return 0;
    memcpy(text, data, size);
    const char *item = text;
    const mcv_result result = mcv_scene_load_document(&document, (mcv_overrides){&item, 1},
                                                      200000000, NULL, &scene, &error);
    fuzz_sentence(result, &error);
    mcv_scene_free(scene);
    free(text);
    return 0;
}
