/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes and parts, .gltf and .glb, with extensions: loaded, checked and packed; and check
 * --strict. Tables of microfacets are not made: they take a tenth of a second each. */
#include "fuzz.h"

#include "check/findings.h"
#include "device/pack.h"
#include "loader/load.h"
#include "strict/strict.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const uint64_t memory = 50000000; /* so that defects of many triangles take no time */
    mcv_scene *scene = NULL;
    mcv_findings findings = {0};
    mcv_packed packed;
    mcv_strict_findings strict;
    mcv_error error = {""};
    fuzz_file("in.gltf", data, size);
    mcv_result result = mcv_strict_check("in.gltf", memory, &strict, &error);
    fuzz_sentence(result, &error);
    if (result == MCV_OK) mcv_strict_free(&strict);
    result =
        mcv_scene_load_cached("in.gltf", (mcv_overrides){NULL, 0}, memory, NULL, &scene, &error);
    fuzz_sentence(result, &error);
    if (result != MCV_OK) return 0;
    if (mcv_warnings_of(scene, &findings, &error) == MCV_OK) mcv_findings_free(&findings);
    result = mcv_pack_for_features(scene, &packed, &error);
    fuzz_sentence(result, &error);
    if (result == MCV_OK) mcv_packed_free(&packed);
    mcv_scene_free(scene);
    return 0;
}
