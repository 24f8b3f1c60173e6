/* SPDX-License-Identifier: Apache-2.0 */
#include "device/features.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "device/light.h"
#include "kernels/path/camera_path.h"
#include "mcvisi/accel.h"
#include "scene/aperture.h"
#include "scene/emitters.h"
#include "scene/lens_map.h"
#include "scene/motion.h"
#include "scene/mesh.h"
#include "scene/sensors.h"
#include "scene/geometry.h"
#include "scene/materials.h"
#include "scene/spectra.h"

static const char *const feature_words[] = {
#define MCV_X(NAME, word, why) word,
    MCV_FEATURES(MCV_X)
#undef MCV_X
};

static const char *const sensor_names[] = {
#define MCV_X(name, key, NAME) #name,
    MCV_SENSORS(MCV_X)
#undef MCV_X
};

void mcv_feature_names(uint64_t features, char *names, size_t size) {
    size_t length = 0;
    names[0] = '\0';
    for (unsigned i = 0; i < MCV_FEATURE_COUNT; ++i) {
        if (!(features >> i & 1) || length >= size) continue;
        length += (size_t)snprintf(names + length, size - length, "%s%s", length > 0 ? " " : "",
                                   feature_words[i]);
    }
}

void mcv_feature_defines(uint64_t features, uint32_t channels, uint32_t sensor_type, bool random,
                         uint32_t slice, char *options, size_t size) {
    snprintf(
        options, size,
        "-DMCV_CHANNELS=%u -DMCV_SENSOR=%s -DMCV_SENSOR_%s=1 -DMCV_SAMPLER_RANDOM=%d -DMCV_SLICE=%u"
#define MCV_X(NAME, word, why) " -DMCV_WITH_" #NAME "=%d"
        MCV_FEATURES(MCV_X)
#undef MCV_X
            ,
        channels, sensor_names[sensor_type], sensor_names[sensor_type], random,
        slice
#define MCV_X(NAME, word, why) , (int)(features >> MCV_FEATURE_##NAME & 1)
            MCV_FEATURES(MCV_X)
#undef MCV_X
    );
}

uint32_t mcv_path_words(uint64_t features, uint32_t channels) {
    MCV_FEATURE_VARIABLES(features)
#define MCV_CHANNELS channels
#define MCV_X(field, words) +(words)
    return 0 MCV_PATH_FIELDS(MCV_X);
#undef MCV_X
#undef MCV_CHANNELS
}

uint32_t mcv_path_branches(uint64_t features) {
    return features >> MCV_FEATURE_SPLIT & 1 ? MCV_SPLIT_BRANCHES : 1;
}

/* --- the decision --- */

/* The features found so far. The first cause of a feature is kept. */
typedef struct finding {
    uint64_t features;
    mcv_feature_causes *causes; /* or NULL */
} finding;

static bool has(const finding *f, unsigned feature) { return f->features >> feature & 1; }

/* Adds a feature if `needed`; the cause is `kind "name"`, or the kind alone. */
static void add(finding *f, unsigned feature, bool needed, const char *kind, const char *name) {
    if (!needed || has(f, feature)) return;
    f->features |= UINT64_C(1) << feature;
    if (!f->causes) return;
    if (name)
        snprintf(f->causes->of[feature], MCV_CAUSE_SIZE, "%s \"%s\"", kind, name);
    else
        snprintf(f->causes->of[feature], MCV_CAUSE_SIZE, "%s", kind);
}

static void drop(finding *f, unsigned feature) {
    f->features &= ~(UINT64_C(1) << feature);
    if (f->causes) f->causes->of[feature][0] = '\0';
}

static bool any_above_0(const double spectrum[3]) {
    return spectrum[0] > 0 || spectrum[1] > 0 || spectrum[2] > 0;
}

static void find_of_material(finding *f, const mcv_material *m) {
    const mcv_medium_params *medium = mcv_material_has_medium(m->type) ? &m->as.medium : NULL;
    const bool diffuse = m->type == MCV_MATERIAL_DIFFUSE,
               glass = m->type == MCV_MATERIAL_DIELECTRIC;
    const bool plate = mcv_material_is_plate(m->type);
    const bool texture = m->texture != MCV_NONE || mcv_material_surface_texture(m) != MCV_NONE;
    const struct {
        unsigned feature;
        bool needed;
    } of[] = {
        {MCV_FEATURE_DIFFUSE, diffuse},
        {MCV_FEATURE_TRANSLUCENT, diffuse && any_above_0(m->as.diffuse.transmittance)},
        {MCV_FEATURE_DIELECTRIC, medium},
        {MCV_FEATURE_ABSORPTION, medium && any_above_0(medium->absorption)},
        {MCV_FEATURE_COATING, glass && m->as.dielectric.coating > 0},
        {MCV_FEATURE_DISPERSION, medium && !mcv_is_grey(medium->ior)},
        {MCV_FEATURE_SPLIT, plate || glass},
        {MCV_FEATURE_SHEET, plate},
        {MCV_FEATURE_MIRROR, m->type == MCV_MATERIAL_MIRROR},
        {MCV_FEATURE_GLOSSY, mcv_material_is_rough(m) || m->type == MCV_MATERIAL_CONDUCTOR},
        {MCV_FEATURE_METAL, m->type == MCV_MATERIAL_CONDUCTOR},
        {MCV_FEATURE_METALLIC, m->type == MCV_MATERIAL_METALLIC_ROUGHNESS},
        {MCV_FEATURE_ROUGH_GLASS, glass && mcv_material_is_rough(m)},
        {MCV_FEATURE_ANISOTROPY, mcv_material_roughness(m).anisotropy > 0},
        {MCV_FEATURE_REFLECTOR, mcv_material_has_own_bsdf(m->type)},
        {MCV_FEATURE_TEXTURE, texture},
    };
    for (size_t i = 0; i < sizeof of / sizeof of[0]; ++i)
        add(f, of[i].feature, of[i].needed, "material", m->name);
}

static void find_of_emitter(finding *f, const mcv_emitter *e) {
    const bool environment = e->type == MCV_EMITTER_ENVIRONMENT;
    const bool punctual = mcv_emitter_is_point_light(e->type) || e->type == MCV_EMITTER_DIRECTIONAL;
    const struct {
        unsigned feature;
        bool needed;
    } of[] = {
        {MCV_FEATURE_PARALLEL, !isnan(mcv_emitter_half_angle(e))},
        {MCV_FEATURE_LIGHT_FIELD, e->type == MCV_EMITTER_LIGHT_FIELD_EMITTER},
        {MCV_FEATURE_PROJECTOR, e->type == MCV_EMITTER_PROJECTOR},
        {MCV_FEATURE_AREA, mcv_emitter_is_surface_light(e->type)},
        {MCV_FEATURE_SCREEN, mcv_screen_has_structure(e)},
        {MCV_FEATURE_ENVIRONMENT, environment && !mcv_is_sampled(e)},
        {MCV_FEATURE_ENVIRONMENT_IMAGE, environment && mcv_is_sampled(e)},
        {MCV_FEATURE_BEAM, e->type == MCV_EMITTER_COLLIMATED_BEAM},
        {MCV_FEATURE_LASER, e->type == MCV_EMITTER_LASER},
        {MCV_FEATURE_PUNCTUAL, punctual},
        {MCV_FEATURE_TEXTURE, e->texture != MCV_NONE},
    };
    for (size_t i = 0; i < sizeof of / sizeof of[0]; ++i)
        add(f, of[i].feature, of[i].needed, "emitter", e->name);
}

/* Does one box lie inside the other, by more than the rounding of coordinates? */
static bool well_inside(const mcv_box3d *inner, const mcv_box3d *outer) {
    for (int k = 0; k < 3; ++k) {
        const double margin = 1e-6 * (outer->upper[k] - outer->lower[k]);
        if (!(inner->lower[k] > outer->lower[k] + margin &&
              inner->upper[k] < outer->upper[k] - margin))
            return false;
    }
    return true;
}

static bool is_dielectric_body(const mcv_scene *scene, const mcv_instance *instance) {
    return mcv_material_has_medium(scene->materials[instance->material].type);
}

/* Are both pieces of exact bodies with one frame, such as those of a lens? */
static bool same_lens(const mcv_scene *scene, const mcv_instance *a, const mcv_instance *b) {
    return scene->meshes[a->mesh].triangle_count == 0 &&
           scene->meshes[b->mesh].triangle_count == 0 &&
           memcmp(&a->to_world, &b->to_world, sizeof a->to_world) == 0;
}

/* Does the mesh of the outer body come near the box of a body inside it? The mesh of a vial does, a
 * lens around a bubble does not. */
static bool comes_near(const mcv_scene *scene, uint32_t outer, const mcv_box3d *inner) {
    const uint32_t triangles = scene->meshes[scene->instances[outer].mesh].triangle_count;
    for (uint32_t t = 0; t < triangles; ++t) {
        double corners[3][3];
        mcv_box3d box;
        mcv_scene_corners(scene, outer, t, corners);
        for (int k = 0; k < 3; ++k) {
            const double margin = 1e-6 * (inner->upper[k] - inner->lower[k]);
            box.lower[k] = fmin(corners[0][k], fmin(corners[1][k], corners[2][k])) - margin;
            box.upper[k] = fmax(corners[0][k], fmax(corners[1][k], corners[2][k])) + margin;
        }
        if (mcv_boxes_overlap(&box, inner)) return true;
    }
    return false;
}

/* May bodies of dielectrics touch? They cannot if their boxes are apart, or if one lies inside the
 * other, away from its surface. `pair` gets the first such pair. */
static bool may_touch(const mcv_scene *scene, const mcv_box3d *boxes, uint32_t pair[2]) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *a = scene->instances + i;
        if (!is_dielectric_body(scene, a)) continue;
        for (uint32_t j = 0; j < i; ++j) {
            const mcv_instance *b = scene->instances + j;
            if (!is_dielectric_body(scene, b) || same_lens(scene, a, b)) continue;
            if (!mcv_boxes_overlap(boxes + i, boxes + j)) continue;
            if (well_inside(boxes + i, boxes + j)
                    ? comes_near(scene, j, boxes + i)
                    : !well_inside(boxes + j, boxes + i) || comes_near(scene, i, boxes + j)) {
                pair[0] = j;
                pair[1] = i;
                return true;
            }
        }
    }
    return false;
}

/* Next-event estimation and its variants, which depend on the packed emitters. */
static void find_next_event(finding *f, const mcv_scene *scene, const mcv_packed *packed) {
    const uint64_t scatters =
        MCV_FEATURE_BIT(DIFFUSE) | MCV_FEATURE_BIT(GLOSSY) | MCV_FEATURE_BIT(REFLECTOR);
    const uint64_t by_chance =
        MCV_FEATURE_BIT(ENVIRONMENT) | MCV_FEATURE_BIT(DIELECTRIC) | MCV_FEATURE_BIT(SHEET);
    bool rectangle = false, emits = false;
    uint32_t count = 0;
    const char *name = NULL, *rectangle_name = NULL;
    if (!(f->features & scatters) || !packed->emitters) return;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        if (!mcv_is_sampled(scene->emitters + i)) continue;
        const mcv_device_emitter *e = &packed->emitters[count++];
        if (e->power > 0 && !emits) name = scene->emitters[i].name;
        if (e->rectangle.width != 0 && !rectangle) rectangle_name = scene->emitters[i].name;
        emits = emits || e->power > 0;
        rectangle = rectangle || e->rectangle.width != 0;
    }
    add(f, MCV_FEATURE_NEXT_EVENT, emits, "emitter", name);
    add(f, MCV_FEATURE_RECTANGLE, emits && rectangle, "emitter", rectangle_name);
    add(f, MCV_FEATURE_REACH, emits && count > 1 && count <= MCV_MOST_REACHING,
        "the number of emitters", NULL);
    add(f, MCV_FEATURE_LIGHT_TREE, emits && packed->light_tree, "the number of emitters", NULL);
    add(f, MCV_FEATURE_MANY_EMITTERS, emits && count > MCV_MOST_REACHING, "the number of emitters",
        NULL);
    add(f, MCV_FEATURE_EARLY_ROULETTE, emits && !(f->features & by_chance),
        "no environment, glass or sheet", NULL);
}

/*
 * The largest angle between a pixel's rays and its chief ray, or an estimate of it behind optics. 0
 * for a pinhole.
 */
static double pupil_half_angle(const mcv_sensor *sensor, bool through_optics) {
    const mcv_telecentric_params *t = &sensor->as.telecentric;
    const mcv_thin_lens_params *l = &sensor->as.thin_lens;
    const mcv_light_field_params *f = &sensor->as.light_field;
    /* Optics may spread the light that the pupil collects over a larger angle. */
    const double spread = through_optics ? 4 : 1;
    if (sensor->type == MCV_SENSOR_TELECENTRIC)
        return spread * atan(t->stopDiameter / 2 / t->focalLength);
    /* Guiding costs a dozen rays per pixel. Light field cameras have many pixels, each of which
     * sees little of the lens. */
    if (sensor->type == MCV_SENSOR_LIGHT_FIELD && (f->binning[0] > 1 || f->binning[1] > 1))
        return 0; /* several chief rays */
    if (sensor->type == MCV_SENSOR_LIGHT_FIELD)
        return atan(f->lensDiameter / 2 / fmin(f->angularResolution[0], f->angularResolution[1]) *
                    fabs(mcv_kappa(f->focalLength, f->imageDistance)));
    if (sensor->type != MCV_SENSOR_THIN_LENS) return 0;
    /* Optics between camera and emitter may make parallel rays diverge. They are assumed to be
     * about as strong as the camera's lens. */
    const double power =
        through_optics ? 1 / l->focalLength : fabs(mcv_kappa(l->focalLength, l->imageDistance));
    return spread * atan(l->lensDiameter / 2 * power);
}

/* The emitter whose cone is narrower than what the sensor's pupil sees of it, or NULL. */
static const char *find_guiding_emitter(const finding *f, const mcv_scene *scene,
                                        const mcv_packed *packed, const mcv_sensor *sensor) {
    const bool through_optics = has(f, MCV_FEATURE_DIELECTRIC) || has(f, MCV_FEATURE_MIRROR);
    const double alpha = pupil_half_angle(sensor, through_optics);
    const double *m = sensor->to_world.m;
    uint32_t number = 0;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        if (!mcv_is_sampled(scene->emitters + i)) continue;
        const mcv_device_emitter *e = &packed->emitters[number++];
        if (e->type != MCV_EMITTER_PARALLEL || !e->parallel.from_receiver) continue;
        const double beta = 2 * asin((double)e->parallel.sin_half);
        /* The emitter's axis and the node's z both point in the direction of the light. */
        const double cosine =
            e->parallel.axis[0] * m[2] + e->parallel.axis[1] * m[5] + e->parallel.axis[2] * m[8];
        const double apart = acos(fmin(fmax(cosine, -1), 1));
        const bool facing =
            through_optics || sensor->type != MCV_SENSOR_TELECENTRIC || apart <= alpha + beta;
        if (beta < alpha && facing) return scene->emitters[i].name;
    }
    return NULL;
}

uint64_t mcv_decide_features(const mcv_scene *scene, const mcv_packed *packed,
                             const mcv_sensor *sensor, mcv_feature_options options,
                             mcv_feature_causes *causes) {
    finding f = {0, causes};
    uint32_t pair[2];
    if (causes) memset(causes, 0, sizeof *causes);
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *instance = &scene->instances[i];
        find_of_material(&f, &scene->materials[instance->material]);
        add(&f, MCV_FEATURE_NORMALS, scene->meshes[instance->mesh].normals, "node", instance->name);
        add(&f, MCV_FEATURE_MOVING, instance->moves, "node", instance->name);
        add(&f, MCV_FEATURE_MOTION, instance->moves, "node", instance->name);
    }
    for (uint32_t i = 0; i < scene->emitter_count; ++i) find_of_emitter(&f, &scene->emitters[i]);
    add(&f, MCV_FEATURE_SURFACES, scene->solid_count > 0, "exact surfaces", NULL);
    if (may_touch(scene, packed->boxes, pair))
        add(&f, MCV_FEATURE_CONTACT, true, "node", scene->instances[pair[1]].name);
    find_next_event(&f, scene, packed);
    add(&f, MCV_FEATURE_MIXED, options.mixed, "--precision mixed", NULL);
    add(&f, MCV_FEATURE_RECORDS, options.records, "transport", NULL);
    if (sensor) {
        const bool needs_time = mcv_needs_time(scene, sensor);
        const char *guiding = find_guiding_emitter(&f, scene, packed, sensor);
        const mcv_lens_map map = mcv_sensor_lens_map(sensor);
        add(&f, MCV_FEATURE_MOTION, needs_time, "sensor", sensor->name);
        add(&f, MCV_FEATURE_APERTURE, mcv_sensor_aperture(sensor).shape != MCV_APERTURE_DISC,
            "sensor", sensor->name);
        add(&f, MCV_FEATURE_DISTORTION,
            mcv_lens_map_is_used(&map) || (sensor->type == MCV_SENSOR_TELECENTRIC &&
                                           sensor->as.telecentric.relativeIllumination.count > 0),
            "sensor", sensor->name);
        add(&f, MCV_FEATURE_PUPIL_GUIDE, guiding && !needs_time, "emitter", guiding);
        add(&f, MCV_FEATURE_LIGHT_TRACING, !needs_time && mcv_traces_light(packed, sensor),
            "sensor", sensor->name);
    }
    if (options.no_light_paths) drop(&f, MCV_FEATURE_LIGHT_TRACING);
    if (options.no_split) drop(&f, MCV_FEATURE_SPLIT);
    return f.features;
}
