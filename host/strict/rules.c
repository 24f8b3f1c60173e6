/* SPDX-License-Identifier: Apache-2.0 */
/* Source: glTF 2.0 specification, section 5 (properties reference), and the registry of extensions.
 * Members that may hold anything (extras) are left out. */
#include "strict/rules.h"

#include <math.h>
#include <stddef.h>

#define NAME \
    { .key = "name", .kind = MCV_RULE_STRING }
#define NUMBER(key_, low_, high_) \
    { .key = (key_), .kind = MCV_RULE_NUMBER, .low = (low_), .high = (high_) }
#define INTEGER(key_, low_, high_) \
    { .key = (key_), .kind = MCV_RULE_INTEGER, .low = (low_), .high = (high_) }
#define NEEDED_INTEGER(key_, low_, high_) \
    { .key = (key_), .kind = MCV_RULE_INTEGER, .low = (low_), .high = (high_), .required = true }
#define NEEDED_ABOVE(key_, low_) \
    { \
        .key = (key_), .kind = MCV_RULE_NUMBER, .low = (low_), .high = HUGE_VAL, .above = true, \
        .required = true \
    }
#define STRING(key_) \
    { .key = (key_), .kind = MCV_RULE_STRING }
#define NEEDED_STRING(key_) \
    { .key = (key_), .kind = MCV_RULE_STRING, .required = true }
#define STRINGS(key_) \
    { .key = (key_), .kind = MCV_RULE_STRINGS }
#define BOOLEAN(key_) \
    { .key = (key_), .kind = MCV_RULE_BOOLEAN }
#define OBJECT(key_, of_) \
    { .key = (key_), .kind = MCV_RULE_OBJECT, .of = &(of_) }
#define NEEDED_OBJECT(key_, of_) \
    { .key = (key_), .kind = MCV_RULE_OBJECT, .of = &(of_), .required = true }
#define LIST(key_, of_) \
    { .key = (key_), .kind = MCV_RULE_LIST, .of = &(of_) }
#define NEEDED_LIST(key_, of_) \
    { .key = (key_), .kind = MCV_RULE_LIST, .of = &(of_), .required = true }
#define NUMBERS(key_, n_) \
    { .key = (key_), .kind = MCV_RULE_NUMBERS, .least = (n_), .most = (n_) }
#define SHARES(key_, n_) \
    { .key = (key_), .kind = MCV_RULE_NUMBERS, .least = (n_), .most = (n_), .high = 1 }
#define INDEX(key_, to_) \
    { .key = (key_), .kind = MCV_RULE_INDEX, .to = (to_) }
#define NEEDED_INDEX(key_, to_) \
    { .key = (key_), .kind = MCV_RULE_INDEX, .to = (to_), .required = true }
#define INDICES(key_, to_) \
    { .key = (key_), .kind = MCV_RULE_INDICES, .to = (to_) }
#define NEEDED_INDICES(key_, to_) \
    { .key = (key_), .kind = MCV_RULE_INDICES, .to = (to_), .required = true }
#define END \
    { .key = NULL }
#define TYPE(name_, ...) \
    static const mcv_rule name_##_rules[] = {__VA_ARGS__, END}; \
    static const mcv_rule_type name_ = {#name_, name_##_rules};

TYPE(asset, NEEDED_STRING("version"), STRING("minVersion"), STRING("generator"),
     STRING("copyright"))
TYPE(sparse_indices, NEEDED_INDEX("bufferView", "bufferViews"), INTEGER("byteOffset", 0, HUGE_VAL),
     NEEDED_INTEGER("componentType", 0, HUGE_VAL))
TYPE(sparse_values, NEEDED_INDEX("bufferView", "bufferViews"), INTEGER("byteOffset", 0, HUGE_VAL))
TYPE(sparse, NEEDED_INTEGER("count", 1, HUGE_VAL), NEEDED_OBJECT("indices", sparse_indices),
     NEEDED_OBJECT("values", sparse_values))
TYPE(accessor, INDEX("bufferView", "bufferViews"), INTEGER("byteOffset", 0, HUGE_VAL),
     NEEDED_INTEGER("componentType", 0, HUGE_VAL), BOOLEAN("normalized"),
     NEEDED_INTEGER("count", 1, HUGE_VAL), NEEDED_STRING("type"),
     {.key = "max", .kind = MCV_RULE_NUMBERS, .least = 1, .most = 16},
     {.key = "min", .kind = MCV_RULE_NUMBERS, .least = 1, .most = 16}, OBJECT("sparse", sparse),
     NAME)
TYPE(animation_target, INDEX("node", "nodes"), NEEDED_STRING("path"))
TYPE(animation_channel, NEEDED_INTEGER("sampler", 0, HUGE_VAL),
     NEEDED_OBJECT("target", animation_target))
TYPE(animation_sampler, NEEDED_INDEX("input", "accessors"), STRING("interpolation"),
     NEEDED_INDEX("output", "accessors"))
TYPE(animation, NEEDED_LIST("channels", animation_channel),
     NEEDED_LIST("samplers", animation_sampler), NAME)
TYPE(buffer, STRING("uri"), NEEDED_INTEGER("byteLength", 1, HUGE_VAL), NAME)
TYPE(buffer_view, NEEDED_INDEX("buffer", "buffers"), INTEGER("byteOffset", 0, HUGE_VAL),
     NEEDED_INTEGER("byteLength", 1, HUGE_VAL), INTEGER("byteStride", 4, 252),
     INTEGER("target", 0, HUGE_VAL), NAME)
TYPE(orthographic, {.key = "xmag", .kind = MCV_RULE_NUMBER, .required = true},
     {.key = "ymag", .kind = MCV_RULE_NUMBER, .required = true}, NEEDED_ABOVE("zfar", 0),
     {.key = "znear", .kind = MCV_RULE_NUMBER, .high = HUGE_VAL, .required = true})
TYPE(perspective, {.key = "aspectRatio", .kind = MCV_RULE_NUMBER, .high = HUGE_VAL, .above = true},
     NEEDED_ABOVE("yfov", 0),
     {.key = "zfar", .kind = MCV_RULE_NUMBER, .high = HUGE_VAL, .above = true},
     NEEDED_ABOVE("znear", 0))
TYPE(camera, OBJECT("orthographic", orthographic), OBJECT("perspective", perspective),
     NEEDED_STRING("type"), NAME)
TYPE(image, STRING("uri"), STRING("mimeType"), INDEX("bufferView", "bufferViews"), NAME)
TYPE(texture_info, NEEDED_INDEX("index", "textures"), INTEGER("texCoord", 0, HUGE_VAL))
static const mcv_rule normal_texture_rules[] = {NEEDED_INDEX("index", "textures"),
                                                INTEGER("texCoord", 0, HUGE_VAL),
                                                {.key = "scale", .kind = MCV_RULE_NUMBER},
                                                END};
static const mcv_rule_type normal_texture = {"texture_info", normal_texture_rules};
static const mcv_rule occlusion_texture_rules[] = {NEEDED_INDEX("index", "textures"),
                                                   INTEGER("texCoord", 0, HUGE_VAL),
                                                   NUMBER("strength", 0, 1), END};
static const mcv_rule_type occlusion_texture = {"texture_info", occlusion_texture_rules};
TYPE(metallic_roughness, SHARES("baseColorFactor", 4), OBJECT("baseColorTexture", texture_info),
     NUMBER("metallicFactor", 0, 1), NUMBER("roughnessFactor", 0, 1),
     OBJECT("metallicRoughnessTexture", texture_info))
TYPE(material, OBJECT("pbrMetallicRoughness", metallic_roughness),
     OBJECT("normalTexture", normal_texture), OBJECT("occlusionTexture", occlusion_texture),
     OBJECT("emissiveTexture", texture_info), SHARES("emissiveFactor", 3), STRING("alphaMode"),
     NUMBER("alphaCutoff", 0, HUGE_VAL), BOOLEAN("doubleSided"), NAME)
static const mcv_rule target_rules[] = {END};
static const mcv_rule_type morph_target = {"morph_target", target_rules};
TYPE(primitive,
     {.key = "attributes", .kind = MCV_RULE_REFERENCES, .to = "accessors", .required = true},
     INDEX("indices", "accessors"), INDEX("material", "materials"), INTEGER("mode", 0, HUGE_VAL),
     LIST("targets", morph_target))
TYPE(mesh, NEEDED_LIST("primitives", primitive), NUMBERS("weights", 0), NAME)
TYPE(node, INDEX("camera", "cameras"), INDICES("children", "nodes"), INDEX("skin", "skins"),
     NUMBERS("matrix", 16), INDEX("mesh", "meshes"),
     {.key = "rotation", .kind = MCV_RULE_NUMBERS, .least = 4, .most = 4, .low = -1, .high = 1},
     NUMBERS("scale", 3), NUMBERS("translation", 3), NUMBERS("weights", 0), NAME)
TYPE(sampler, INTEGER("magFilter", 0, HUGE_VAL), INTEGER("minFilter", 0, HUGE_VAL),
     INTEGER("wrapS", 0, HUGE_VAL), INTEGER("wrapT", 0, HUGE_VAL), NAME)
TYPE(scene, INDICES("nodes", "nodes"), NAME)
TYPE(skin, INDEX("inverseBindMatrices", "accessors"), INDEX("skeleton", "nodes"),
     NEEDED_INDICES("joints", "nodes"), NAME)
TYPE(texture, INDEX("sampler", "samplers"), INDEX("source", "images"), NAME)

static const mcv_rule root_rules[] = {NEEDED_OBJECT("asset", asset),
                                      STRINGS("extensionsUsed"),
                                      STRINGS("extensionsRequired"),
                                      LIST("accessors", accessor),
                                      LIST("animations", animation),
                                      LIST("buffers", buffer),
                                      LIST("bufferViews", buffer_view),
                                      LIST("cameras", camera),
                                      LIST("images", image),
                                      LIST("materials", material),
                                      LIST("meshes", mesh),
                                      LIST("nodes", node),
                                      LIST("samplers", sampler),
                                      INDEX("scene", "scenes"),
                                      LIST("scenes", scene),
                                      LIST("skins", skin),
                                      LIST("textures", texture),
                                      END};
const mcv_rule_type mcv_rule_root = {"glTF", root_rules};

/* --- extensions --- */

static const mcv_rule none[] = {END};
static const mcv_rule spot_rules[] = {NUMBER("innerConeAngle", 0, HUGE_VAL),
                                      NUMBER("outerConeAngle", 0, M_PI_2), END};
static const mcv_rule_type spot = {"spot", spot_rules};
TYPE(light, SHARES("color", 3), NUMBER("intensity", 0, HUGE_VAL), NEEDED_STRING("type"),
     {.key = "range", .kind = MCV_RULE_NUMBER, .high = HUGE_VAL, .above = true},
     OBJECT("spot", spot), NAME)
static const mcv_rule lights[] = {NEEDED_LIST("lights", light), END};
static const mcv_rule light_use[] = {NEEDED_INDEX("light", "extensions/KHR_lights_punctual/lights"),
                                     END};
static const mcv_rule anisotropy[] = {NUMBER("anisotropyStrength", 0, 1),
                                      {.key = "anisotropyRotation", .kind = MCV_RULE_NUMBER},
                                      OBJECT("anisotropyTexture", texture_info),
                                      END};
static const mcv_rule clearcoat[] = {NUMBER("clearcoatFactor", 0, 1),
                                     OBJECT("clearcoatTexture", texture_info),
                                     NUMBER("clearcoatRoughnessFactor", 0, 1),
                                     OBJECT("clearcoatRoughnessTexture", texture_info),
                                     OBJECT("clearcoatNormalTexture", normal_texture),
                                     END};
static const mcv_rule dispersion[] = {NUMBER("dispersion", 0, HUGE_VAL), END};
static const mcv_rule emissive[] = {NUMBER("emissiveStrength", 0, HUGE_VAL), END};
static const mcv_rule ior[] = {NUMBER("ior", 0, HUGE_VAL), END}; /* and not between 0 and 1 */
static const mcv_rule iridescence[] = {NUMBER("iridescenceFactor", 0, 1),
                                       OBJECT("iridescenceTexture", texture_info),
                                       NUMBER("iridescenceIor", 1, HUGE_VAL),
                                       NUMBER("iridescenceThicknessMinimum", 0, HUGE_VAL),
                                       NUMBER("iridescenceThicknessMaximum", 0, HUGE_VAL),
                                       OBJECT("iridescenceThicknessTexture", texture_info),
                                       END};
static const mcv_rule glossiness[] = {SHARES("diffuseFactor", 4),
                                      OBJECT("diffuseTexture", texture_info),
                                      SHARES("specularFactor", 3),
                                      NUMBER("glossinessFactor", 0, 1),
                                      OBJECT("specularGlossinessTexture", texture_info),
                                      END};
static const mcv_rule sheen[] = {
    SHARES("sheenColorFactor", 3), OBJECT("sheenColorTexture", texture_info),
    NUMBER("sheenRoughnessFactor", 0, 1), OBJECT("sheenRoughnessTexture", texture_info), END};
static const mcv_rule specular[] = {
    NUMBER("specularFactor", 0, 1), OBJECT("specularTexture", texture_info),
    NUMBERS("specularColorFactor", 3), OBJECT("specularColorTexture", texture_info), END};
static const mcv_rule transmission[] = {NUMBER("transmissionFactor", 0, 1),
                                        OBJECT("transmissionTexture", texture_info), END};
static const mcv_rule volume[] = {
    NUMBER("thicknessFactor", 0, HUGE_VAL),
    OBJECT("thicknessTexture", texture_info),
    {.key = "attenuationDistance", .kind = MCV_RULE_NUMBER, .high = HUGE_VAL, .above = true},
    SHARES("attenuationColor", 3),
    END};
TYPE(variant, NEEDED_STRING("name"))
static const mcv_rule variants[] = {NEEDED_LIST("variants", variant), END};
TYPE(mapping, NEEDED_INDICES("variants", "extensions/KHR_materials_variants/variants"),
     NEEDED_INDEX("material", "materials"), NAME)
static const mcv_rule mappings[] = {NEEDED_LIST("mappings", mapping), END};
static const mcv_rule visibility[] = {BOOLEAN("visible"), END};
static const mcv_rule transform[] = {NUMBERS("offset", 2),
                                     {.key = "rotation", .kind = MCV_RULE_NUMBER},
                                     NUMBERS("scale", 2),
                                     INTEGER("texCoord", 0, HUGE_VAL),
                                     END};
static const mcv_rule pointer[] = {NEEDED_STRING("pointer"), END};
static const mcv_rule source[] = {INDEX("source", "images"), END};

const mcv_rule_extension mcv_rule_extensions[] = {
    {"EXT_texture_webp", &texture, source},
    {"KHR_animation_pointer", &animation_target, pointer},
    {"KHR_lights_punctual", &mcv_rule_root, lights},
    {"KHR_lights_punctual", &node, light_use},
    {"KHR_materials_anisotropy", &material, anisotropy},
    {"KHR_materials_clearcoat", &material, clearcoat},
    {"KHR_materials_dispersion", &material, dispersion},
    {"KHR_materials_emissive_strength", &material, emissive},
    {"KHR_materials_ior", &material, ior},
    {"KHR_materials_iridescence", &material, iridescence},
    {"KHR_materials_pbrSpecularGlossiness", &material, glossiness},
    {"KHR_materials_sheen", &material, sheen},
    {"KHR_materials_specular", &material, specular},
    {"KHR_materials_transmission", &material, transmission},
    {"KHR_materials_unlit", &material, none},
    {"KHR_materials_variants", &mcv_rule_root, variants},
    {"KHR_materials_variants", &primitive, mappings},
    {"KHR_materials_volume", &material, volume},
    {"KHR_mesh_quantization", NULL, none},
    {"KHR_node_visibility", &node, visibility},
    {"KHR_texture_basisu", &texture, source},
    {"KHR_texture_transform", &texture_info, transform},
    {NULL, NULL, NULL}};
