/* SPDX-License-Identifier: Apache-2.0 */
#include "device/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mcvisi/accel.h"
#include "device/albedo.h"
#include "device/gloss.h"
#include "device/light.h"
#include "scene/emitters.h"
#include "scene/mesh.h"
#include "scene/solid.h"
#include "scene/transform.h"

static const double pi = 3.14159265358979323846;

static void *allocate(size_t count, size_t size, bool *failed) {
    void *memory = calloc(count > 0 ? count : 1, size);
    if (!memory) *failed = true;
    return memory;
}

void mcv_packed_free(mcv_packed *packed) {
    free(packed->boxes);
    free(packed->positions);
    free(packed->normals);
    free(packed->texcoords);
    free(packed->tangents);
    free(packed->indices);
    free(packed->triangles);
    free(packed->instances);
    free(packed->materials);
    free(packed->gloss);
    free(packed->albedos);
    free(packed->albedo_sources);
    free(packed->emitters);
    free(packed->emitter_cdf);
    free(packed->textures);
    free(packed->texels);
    free(packed->solids);
    free(packed->position_lows);
    free(packed->normal_lows);
    free(packed->precise_solids);
    memset(packed, 0, sizeof *packed);
}

static uint32_t feature(unsigned index, bool present) { return present ? 1u << index : 0u; }

/* Geometry */

static mcv_box empty_box(void) {
    return (mcv_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static void extend(mcv_box *b, const double p[3]) {
    for (int k = 0; k < 3; ++k) {
        if (p[k] < b->lower[k]) b->lower[k] = p[k];
        if (p[k] > b->upper[k]) b->upper[k] = p[k];
    }
}

/* Touching boxes overlap, whatever their coordinates round. */
static bool overlap(const mcv_box *a, const mcv_box *b) {
    for (int k = 0; k < 3; ++k) {
        const double margin = 1e-6 * (a->upper[k] - a->lower[k] + b->upper[k] - b->lower[k]);
        if (a->upper[k] + margin < b->lower[k] || b->upper[k] + margin < a->lower[k]) return false;
    }
    return true;
}

/* The scene's centre on a grid of an eighth of its size, a power of two: moving the scene by whole
 * grid steps changes no bit. */
static void find_centre(const mcv_box *boxes, uint32_t count, double centre[3]) {
    mcv_box all = empty_box();
    double size = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (!(boxes[i].lower[0] <= boxes[i].upper[0])) continue;
        extend(&all, boxes[i].lower);
        extend(&all, boxes[i].upper);
    }
    for (int k = 0; k < 3; ++k) size = fmax(size, all.upper[k] - all.lower[k]);
    const double grid = size > 0 && isfinite(size) ? exp2(floor(log2(size)) - 3) : 0;
    for (int k = 0; k < 3; ++k) {
        const double middle = 0.5 * (all.lower[k] + all.upper[k]);
        centre[k] = !isfinite(middle) ? 0 : grid > 0 ? grid * round(middle / grid) : middle;
    }
}

void mcv_pack_normal(const mcv_scene *scene, uint32_t instance, uint32_t vertex, double n[3]) {
    const mcv_instance *placed = &scene->instances[instance];
    const float *from = scene->meshes[placed->mesh].normals + 3 * (size_t)vertex;
    mcv_transform_normal(&placed->to_world, (const double[3]){from[0], from[1], from[2]}, n);
    if (!mcv_normalize3(n, n)) memset(n, 0, 3 * sizeof *n);
}

static void pack_instance(const mcv_scene *scene, mcv_packed *packed, uint32_t index,
                          uint32_t first_vertex) {
    const mcv_instance *instance = &scene->instances[index];
    const mcv_mesh *mesh = &scene->meshes[instance->mesh];
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const size_t to = first_vertex + (size_t)v;
        double p[3];
        mcv_scene_vertex(scene, index, v, p);
        for (int k = 0; k < 3; ++k)
            packed->positions[3 * to + k] = (float)(p[k] - packed->centre[k]);
        if (packed->normals && mesh->normals) {
            double n[3];
            mcv_pack_normal(scene, index, v, n);
            for (int k = 0; k < 3; ++k) packed->normals[3 * to + k] = (float)n[k];
        }
        if (packed->tangents && mesh->tangents) {
            double t[4];
            mcv_scene_tangent(scene, index, v, t);
            for (int k = 0; k < 4; ++k) packed->tangents[4 * to + k] = (float)t[k];
        }
        if (packed->texcoords && mesh->texcoords)
            memcpy(packed->texcoords + 2 * to, mesh->texcoords + 2 * (size_t)v, 2 * sizeof(float));
        if (packed->texcoords && packed->texcoord_sets > 1 && mesh->texcoords1)
            memcpy(packed->texcoords + 2 * (packed->vertex_count + to),
                   mesh->texcoords1 + 2 * (size_t)v, 2 * sizeof(float));
    }
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const size_t to = instance->first_triangle + (size_t)t;
        uint32_t corners[3];
        mcv_scene_triangle(scene, index, t, corners);
        for (int k = 0; k < 3; ++k) {
            packed->indices[3 * to + k] = first_vertex + corners[k];
            packed->triangles[4 * to + k] = first_vertex + corners[k];
        }
        packed->triangles[4 * to + 3] = index;
    }
}

/* Media */

/* One medium: bodies of one material that keep apart share it. */
typedef struct body_medium {
    uint32_t material;
    double priority;
} body_medium;

static bool comes_before(const body_medium *a, const body_medium *b) {
    return a->priority != b->priority ? a->priority < b->priority : a->material < b->material;
}

/* Media 0 … count as light of one channel meets them; m > 0 is of the material materials[m]. */
static void pack_media(const mcv_scene *scene, mcv_packed *packed, uint32_t count,
                       const uint32_t *materials, int channel) {
    double index[MCV_MAX_MEDIA + 1] = {1.0};
    for (uint32_t m = 1; m <= count; ++m) {
        const mcv_dielectric_params *params = &scene->materials[materials[m]].as.dielectric;
        index[m] = params->ior[channel];
        for (int k = 0; k < 3; ++k)
            packed->media[channel][m].absorption[k] = (float)params->absorption[k];
    }
    for (uint32_t a = 0; a <= count; ++a) {
        packed->media[channel][a].inverse_index_squared = (float)(1 / (index[a] * index[a]));
        for (uint32_t b = 0; b <= count; ++b) {
            mcv_device_interface *between =
                &packed->interfaces[channel][a * (MCV_MAX_MEDIA + 1) + b];
            between->eta = (float)(index[a] / index[b]);
            between->delta =
                (float)((index[b] - index[a]) * (index[b] + index[a]) / (index[b] * index[b]));
            /* The later medium owns the surface between two: it has the higher priority. */
            const uint32_t owner = a > b ? a : b, other = a > b ? b : a;
            double scale, offset;
            mcv_coat(owner > 0
                         ? mcv_material_coating(&scene->materials[materials[owner]], index[other])
                         : 0,
                     index[a], index[b], &scale, &offset);
            between->scale = (float)scale;
            between->offset = (float)offset;
        }
    }
}

/*
 * Gives each dielectric instance a medium, so that a path can keep the set of the bodies it is in
 * as bits, the highest priority on top. Bodies of one material whose boxes do not touch share a
 * bit.
 */
static mcv_result assign_media(const mcv_scene *scene, const mcv_packed *earlier,
                               mcv_packed *packed, mcv_error *error) {
    const mcv_box *boxes = packed->boxes;
    body_medium media[MCV_MAX_MEDIA];
    uint32_t count = 0;
    uint32_t *medium_of = calloc(scene->instance_count + 1,
                                 sizeof *medium_of); /* 1 + index into media before sorting */
    if (!medium_of) return mcv_fail(error, MCV_FAILED, "%s: no memory for the media", scene->path);
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const uint32_t material = scene->instances[i].material;
        if (scene->materials[material].type != MCV_MATERIAL_DIELECTRIC) continue;
        uint32_t taken = 0; /* bits of media that this body must not share */
        for (uint32_t j = 0; j < i; ++j) {
            if (medium_of[j] > 0 && overlap(&boxes[i], &boxes[j]))
                taken |= 1u << (medium_of[j] - 1);
        }
        for (uint32_t m = 0; m < count && medium_of[i] == 0; ++m) {
            if (media[m].material == material && !(taken >> m & 1)) medium_of[i] = m + 1;
        }
        if (medium_of[i] > 0) continue;
        if (count == MCV_MAX_MEDIA) {
            free(medium_of);
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: nodes: more than %d dielectric bodies differ in material or "
                            "overlap: join those of one material into one mesh",
                            scene->path, MCV_MAX_MEDIA);
        }
        media[count] = (body_medium){material, scene->materials[material].as.dielectric.priority};
        medium_of[i] = ++count;
    }

    /* Sorted by priority, ties as they came: the order carries the old number along in an index
     * table. */
    uint32_t place[MCV_MAX_MEDIA] = {0}; /* new number of an old one */
    body_medium sorted[MCV_MAX_MEDIA] = {{0}};
    for (uint32_t m = 0; m < count; ++m) {
        place[m] = 0;
        for (uint32_t o = 0; o < count; ++o) {
            if (comes_before(&media[o], &media[m]) ||
                (o < m && !comes_before(&media[m], &media[o])))
                ++place[m];
        }
        sorted[place[m]] = media[m];
    }
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        packed->instances[i].medium = medium_of[i] > 0 ? place[medium_of[i] - 1] + 1 : 0;
    free(medium_of);

    uint32_t materials[MCV_MAX_MEDIA + 1] = {0};
    for (uint32_t m = 0; m < count; ++m) materials[m + 1] = sorted[m].material;
    for (int channel = 0; channel < 3; ++channel)
        pack_media(scene, packed, count, materials, channel);
    if (!packed->gloss) return MCV_OK;
    double index[MCV_MAX_MEDIA + 1] = {1.0};
    for (uint32_t m = 1; m <= count; ++m)
        index[m] = scene->materials[materials[m]].as.dielectric.ior[MCV_ALBEDO_CHANNEL];
    return mcv_pack_interfaces(scene, earlier, packed, count, materials, index, error);
}

/*
 * Does the closed surface go round the point? The solid angles that its triangles subtend there
 * (van Oosterom and Strackee 1983) add up to ±4π or to 0, with no ray that could meet an edge; an
 * open surface has less than half and surrounds nothing.
 */
static bool surrounds(const mcv_scene *scene, uint32_t instance, const double point[3]) {
    for (uint32_t i = 0; i < scene->solid_count; ++i)
        if (scene->solids[i].instances[0] == instance)
            return mcv_solid_holds(scene->solids + i, point);
    const uint32_t triangles = scene->meshes[scene->instances[instance].mesh].triangle_count;
    double half_angle = 0;
    for (uint32_t t = 0; t < triangles; ++t) {
        double c[3][3];
        double length[3];
        mcv_scene_corners(scene, instance, t, c);
        for (int v = 0; v < 3; ++v) {
            for (int k = 0; k < 3; ++k) c[v][k] -= point[k];
            length[v] = sqrt(c[v][0] * c[v][0] + c[v][1] * c[v][1] + c[v][2] * c[v][2]);
        }
        const double ab = c[0][0] * c[1][0] + c[0][1] * c[1][1] + c[0][2] * c[1][2];
        const double bc = c[1][0] * c[2][0] + c[1][1] * c[2][1] + c[1][2] * c[2][2];
        const double ca = c[2][0] * c[0][0] + c[2][1] * c[0][1] + c[2][2] * c[0][2];
        const double volume = c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) +
                              c[0][1] * (c[1][2] * c[2][0] - c[1][0] * c[2][2]) +
                              c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
        half_angle += atan2(volume, length[0] * length[1] * length[2] + ab * length[2] +
                                        bc * length[0] + ca * length[1]);
    }
    return fabs(half_angle) > pi;
}

uint32_t mcv_media_around(const mcv_scene *scene, const mcv_packed *packed, const double point[3]) {
    uint32_t media = 0;
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        if (packed->instances[i].medium == 0) continue;
        const mcv_box b = packed->boxes[i];
        bool maybe = true;
        for (int k = 0; k < 3; ++k)
            maybe = maybe && point[k] >= b.lower[k] && point[k] <= b.upper[k];
        if (maybe && surrounds(scene, i, point)) media |= 1u << (packed->instances[i].medium - 1);
    }
    return media;
}

/* Materials and textures */

static double largest(const double spectrum[3]) {
    return fmax(spectrum[0], fmax(spectrum[1], spectrum[2]));
}

/* What a surface lets through, and the chance with which it is taken to reflect. */
static void share_out(const double reflectance[3], const double transmittance[3],
                      mcv_device_material *out) {
    const double reflected = largest(reflectance), passed = largest(transmittance);
    for (int k = 0; k < 3; ++k) out->passed[k] = (float)transmittance[k];
    out->chance = reflected + passed > 0 ? (float)(reflected / (reflected + passed)) : 0;
}

/* From this α on, a roughness of 1/2, highlights are tens of degrees wide. */
static const double wide_alpha = 0.25;

/* Below the layer of what is no metal light is spread all around. */
static bool is_sharp(const mcv_material *material) {
    const mcv_roughness surface = mcv_material_roughness(material);
    const double alpha = surface.roughness * surface.roughness;
    const bool layered = material->type == MCV_MATERIAL_METALLIC_ROUGHNESS &&
                         (material->as.metallic_roughness.metallic < 1 ||
                          mcv_material_surface_texture(material) != MCV_NONE);
    return mcv_material_is_rough(material) && !layered &&
           alpha + (1 - alpha) * surface.anisotropy < wide_alpha;
}

static mcv_device_material pack_material(const mcv_material *material) {
    mcv_device_material out = {.type = material->type, .texture = material->texture};
    const double *value = NULL;
    switch (material->type) {
    case MCV_MATERIAL_DIFFUSE:
        value = material->as.diffuse.reflectance;
        share_out(value, material->as.diffuse.transmittance, &out);
        out.scattering_sides = largest(material->as.diffuse.transmittance) > 0 ? 2 : 1;
        break;
    case MCV_MATERIAL_MIRROR:
        value = material->as.mirror.reflectance;
        break;
    case MCV_MATERIAL_METALLIC_ROUGHNESS:
        value = material->as.metallic_roughness.baseColor;
        break;
    case MCV_MATERIAL_SHEET: {
        const double n = material->as.sheet.ior;
        value = material->as.sheet.transmittance;
        out.eta = (float)(1 / n);
        out.delta = (float)((n - 1) * (n + 1) / (n * n));
        break;
    }
    case MCV_MATERIAL_BEAM_SPLITTER: {
        const mcv_beam_splitter_params *p = &material->as.beam_splitter;
        value = p->reflectance;
        share_out(value, p->transmittance, &out);
        break;
    }
    case MCV_MATERIAL_RETROREFLECTOR: {
        const mcv_retroreflector_params *p = &material->as.retroreflector;
        value = p->reflectance;
        for (int k = 0; k < 3; ++k) out.passed[k] = (float)p->diffuseReflectance[k];
        out.spread = p->divergence > 0 ? (float)tan(fmax(p->divergence, MCV_LEAST_DIVERGENCE)) : 0;
        out.fall = (float)(1 / tan(p->entranceAngle));
        out.scattering_sides = p->divergence > 0 || largest(p->diffuseReflectance) > 0;
        break;
    }
    default:
        break;
    }
    for (int k = 0; value && k < 3; ++k) out.value[k] = (float)value[k];
    if (mcv_material_is_rough(material))
        out.scattering_sides = material->type == MCV_MATERIAL_CONDUCTOR ? 1 : 2;
    const double roughness = mcv_material_roughness(material).roughness;
    const bool matt =
        material->type == MCV_MATERIAL_METALLIC_ROUGHNESS && roughness * roughness >= wide_alpha;
    out.connectable = material->type == MCV_MATERIAL_DIFFUSE || matt;
    out.near_specular = is_sharp(material);
    return out;
}

/* Words of device memory per texel. */
static size_t texel_words(const mcv_texture *texture) { return texture->linear ? 3 : 1; }

/* Word of its first texel; that of the one before whose pixels it shares. */
static uint32_t first_texel(const mcv_scene *scene, const mcv_packed *packed, uint32_t texture,
                            size_t next) {
    const mcv_texture *t = &scene->textures[texture];
    for (uint32_t i = 0; t->shares_pixels && i < texture; ++i)
        if (scene->textures[i].rgba == t->rgba && scene->textures[i].linear == t->linear)
            return packed->textures[i].first;
    return (uint32_t)next;
}

static void pack_textures(const mcv_scene *scene, mcv_packed *packed) {
    static const double as_it_is[6] = {1, 0, 0, 0, 1, 0};
    size_t next = 256;
    for (unsigned i = 0; i < 256; ++i)
        packed->texels[i] = as_uint((float)mcv_srgb_decode((uint8_t)i));
    for (uint32_t i = 0; i < scene->texture_count; ++i) {
        const mcv_texture *texture = &scene->textures[i];
        packed->textures[i] =
            (mcv_device_texture){.width = texture->width,
                                 .height = texture->height,
                                 .first = first_texel(scene, packed, i, next),
                                 .first_texcoord = texture->texcoord_set * packed->vertex_count,
                                 .wrap_s = texture->wrap_s,
                                 .wrap_t = texture->wrap_t,
                                 .nearest = texture->nearest,
                                 .linear = texture->linear != NULL};
        for (int k = 0; k < 6; ++k)
            packed->textures[i].transform[k] =
                (float)(texture->is_transformed ? texture->transform : as_it_is)[k];
        if (texture->shares_pixels) continue;
        const size_t texels = (size_t)texture->width * texture->height;
        for (size_t k = 0; texture->linear && k < 3 * texels; ++k, ++next)
            packed->texels[next] = as_uint(texture->linear[k]);
        for (size_t k = 0; texture->rgba && k < texels; ++k, ++next) {
            const uint8_t *rgba = texture->rgba + 4 * k;
            packed->texels[next] = rgba[0] | (uint32_t)rgba[1] << 8 | (uint32_t)rgba[2] << 16 |
                                   (uint32_t)rgba[3] << 24;
        }
    }
}

/* Emitters */

/* The diagonal of the box around all instances. */
double mcv_packed_size(const mcv_packed *packed) {
    mcv_box all = empty_box();
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        extend(&all, packed->boxes[i].lower);
        extend(&all, packed->boxes[i].upper);
    }
    const double size =
        sqrt(pow(all.upper[0] - all.lower[0], 2) + pow(all.upper[1] - all.lower[1], 2) +
             pow(all.upper[2] - all.lower[2], 2));
    return isfinite(size) ? size : 0;
}

/* Over all channels; of what comes from infinitely far away that which falls on the scene's ball.
 */
static double emitter_power(const mcv_scene *scene, const mcv_packed *packed,
                            const mcv_emitter *emitter) {
    double mean[3];
    mcv_emitter_image_mean(scene, emitter, mean);
    const double brightness = emitter->radiance[0] * mean[0] + emitter->radiance[1] * mean[1] +
                              emitter->radiance[2] * mean[2];
    const double disk = pi * pow(mcv_packed_size(packed) / 2, 2);
    if (emitter->type == MCV_EMITTER_DIRECTIONAL) return brightness * disk;
    if (emitter->type == MCV_EMITTER_ENVIRONMENT)
        return brightness * mcv_emitter_solid_angle(emitter) * disk;
    return brightness * mcv_emitter_unit_power(scene, emitter);
}

/*
 * A sixteenth of all choices goes in equal parts to all emitters that shine: one that is dim beside
 * the others may be the only one close by, and lights without extent are found in no other way.
 */
static void share_choices(double *powers, uint32_t count) {
    double total = 0;
    uint32_t shining = 0;
    for (uint32_t i = 0; i < count; ++i) {
        total += powers[i];
        shining += powers[i] > 0;
    }
    for (uint32_t i = 0; i < count; ++i)
        if (powers[i] > 0) powers[i] = 15 * powers[i] + total / shining;
}

/* The middle of the instance's box, re-centred. */
static void find_middle(const mcv_packed *packed, uint32_t instance, float middle[3]) {
    const mcv_box *box = &packed->boxes[instance];
    for (int k = 0; k < 3; ++k)
        middle[k] = (float)(0.5 * (box->lower[k] + box->upper[k]) - packed->centre[k]);
}

/* What depends on the type. */
static void prepare_emitter(const mcv_scene *scene, const mcv_packed *packed, uint32_t index,
                            mcv_device_emitter *to) {
    switch (scene->emitters[index].type) {
    case MCV_EMITTER_PARALLEL:
    case MCV_EMITTER_TELECENTRIC_PROJECTOR:
        to->type = MCV_EMITTER_PARALLEL;
        mcv_parallel_prepare(scene, index, &to->parallel);
        break;
    case MCV_EMITTER_LIGHT_FIELD_EMITTER:
        mcv_light_field_emitter_prepare(scene, index, &to->light_field);
        break;
    case MCV_EMITTER_PROJECTOR:
        mcv_projector_prepare(scene, index, &to->projector);
        break;
    case MCV_EMITTER_ENVIRONMENT:
        mcv_environment_prepare(scene, index, &to->environment);
        break;
    case MCV_EMITTER_COLLIMATED_BEAM:
        mcv_collimated_beam_prepare(scene, index, &to->beam);
        break;
    case MCV_EMITTER_POINT:
    case MCV_EMITTER_SPOT:
        to->type = MCV_EMITTER_SPOT;
        mcv_spot_prepare(scene, index, packed->centre, &to->spot);
        break;
    case MCV_EMITTER_DIRECTIONAL:
        mcv_directional_prepare(scene, index, &to->directional);
        break;
    default:
        break;
    }
}

static double length(const double v[3]) { return hypot(hypot(v[0], v[1]), v[2]); }

/* From the middle, which is re-centred, to a triangle's corners. */
static void ways_to(const mcv_scene *scene, const mcv_packed *packed, uint32_t instance,
                    uint32_t triangle, const float middle[3], double ways[3][3]) {
    mcv_scene_corners(scene, instance, triangle, ways);
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) ways[c][k] -= packed->centre[k] + (double)middle[k];
}

/*
 * Where a receiver may look for the emitter, and how its light thins out
 * (kernels/light/selection.h). What comes from infinitely far away has the power that falls on the
 * scene's ball.
 */
static void find_reach(const mcv_scene *scene, const mcv_packed *packed, const mcv_emitter *from,
                       mcv_device_emitter *to) {
    const double size = mcv_packed_size(packed) / 2;
    to->radius = -1;
    to->narrowest = (float)(size * size * (from->type == MCV_EMITTER_ENVIRONMENT ? 4 : 1));
    if (from->type == MCV_EMITTER_ENVIRONMENT || from->type == MCV_EMITTER_DIRECTIONAL) return;
    const bool has_surface = mcv_emitter_has_surface(from->type);
    const double area = has_surface ? from->area : 0,
                 beam = from->type == MCV_EMITTER_COLLIMATED_BEAM;
    to->narrowest = (float)(area / pi);
    to->widening =
        beam ? 0 : (float)(mcv_emitter_unit_power(scene, from) / (pi * (has_surface ? area : 1)));
    to->radius = 0;
    if (!has_surface) {
        memcpy(to->middle, to->spot.position, sizeof to->middle);
        return;
    }
    double radius = 0, facing[3] = {0, 0, 0}, ways[3][3];
    for (uint32_t t = 0; t < to->triangle_count; ++t) {
        double face[3];
        mcv_scene_face_normal(scene, from->instance, t, face);
        ways_to(scene, packed, from->instance, t, to->middle, ways);
        for (int c = 0; c < 3; ++c) radius = fmax(radius, length(ways[c]));
        for (int k = 0; k < 3 && length(face) > 0; ++k)
            facing[k] += face[k] / length(face) / to->triangle_count;
    }
    /* The corners have been rounded, by less than a fourth of that. */
    to->radius = nextafterf((float)(radius + mcv_packed_size(packed) * 0x1p-22), INFINITY);
    /* Flat as far as float coordinates can be: where normals differ, their mean is shorter than 1
     * by the square of the angle. */
    bool is_flat = length(facing) > 1 - 1e-12;
    for (uint32_t t = 0; is_flat && t < to->triangle_count; ++t) {
        ways_to(scene, packed, from->instance, t, to->middle, ways);
        for (int c = 0; c < 3; ++c) {
            const double height =
                ways[c][0] * facing[0] + ways[c][1] * facing[1] + ways[c][2] * facing[2];
            is_flat = is_flat && fabs(height) <= 0x1p-20 * (radius + length(packed->centre));
        }
    }
    for (int k = 0; is_flat && k < 3; ++k) to->facing[k] = (float)facing[k];
}

/* The triangles' shares of the area, from entry `next` of the table on. */
static void pack_surface(const mcv_scene *scene, mcv_packed *packed, const mcv_emitter *from,
                         uint32_t number, size_t next, double *areas) {
    mcv_device_emitter *to = &packed->emitters[number];
    to->cdf = (uint32_t)next;
    to->triangle_count = scene->meshes[scene->instances[from->instance].mesh].triangle_count;
    for (uint32_t t = 0; t < to->triangle_count; ++t)
        areas[t] = mcv_scene_triangle_area(scene, from->instance, t);
    mcv_write_cdf(packed->emitter_cdf + next, to->triangle_count, areas);
    find_middle(packed, from->instance, to->middle);
    packed->instances[from->instance].emitter = number;
}

bool mcv_is_looked_for(const mcv_emitter *emitter) {
    return emitter->type != MCV_EMITTER_ENVIRONMENT || emitter->texture != MCV_NONE;
}

/* Entries of an environment's image in the table of shares: of its rows, then of each row's pixels.
 */
static size_t environment_entries(const mcv_texture *image) {
    return image->height + 1 + (size_t)image->height * (image->width + 1);
}

/* The shares of rows and pixels in what comes from the sky, from entry `next` of the table on. */
static mcv_result pack_environment(const mcv_scene *scene, mcv_packed *packed,
                                   const mcv_emitter *from, uint32_t number, size_t next,
                                   mcv_error *error) {
    const mcv_texture *image = scene->textures + from->texture;
    bool failed = false;
    double *rows = allocate(image->height, sizeof(double), &failed);
    double *pixels = allocate(image->width, sizeof(double), &failed);
    double decoded[256];
    mcv_srgb_table(decoded);
    for (uint32_t row = 0; !failed && row < image->height; ++row) {
        uint32_t *cdf =
            packed->emitter_cdf + next + image->height + 1 + (size_t)row * (image->width + 1);
        for (uint32_t column = 0; column < image->width; ++column) {
            double rgb[3];
            mcv_texture_value(image, decoded, column, row, rgb);
            pixels[column] = from->radiance[0] * rgb[0] + from->radiance[1] * rgb[1] +
                             from->radiance[2] * rgb[2];
        }
        rows[row] = mcv_write_cdf(cdf, image->width, pixels) *
                    sin((2.0 * row + 1) * pi / (2.0 * image->height));
    }
    if (!failed) mcv_write_cdf(packed->emitter_cdf + next, image->height, rows);
    packed->emitters[number].cdf = (uint32_t)next;
    packed->environment_emitter = number;
    free(rows);
    free(pixels);
    return failed ? mcv_fail(error, MCV_FAILED, "%s: no memory for the environment's image",
                             scene->path)
                  : MCV_OK;
}

static mcv_result pack_emitters(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    uint32_t *cdf = packed->emitter_cdf;
    size_t next = packed->emitter_count + 1;
    uint32_t count = 0, rectangles = 0;
    bool failed = false;
    mcv_result result = MCV_OK;
    double *powers = allocate(scene->emitter_count, sizeof(double), &failed);
    double *areas = allocate(scene->triangle_count, sizeof(double), &failed);
    for (uint32_t i = 0; !failed && result == MCV_OK && i < scene->emitter_count; ++i) {
        const mcv_emitter *from = &scene->emitters[i];
        if (!mcv_is_looked_for(from)) continue;
        mcv_device_emitter *to = &packed->emitters[count];
        *to = (mcv_device_emitter){.type = from->type,
                                   .instance = from->instance,
                                   .texture = from->texture,
                                   .area = (float)from->area};
        for (int k = 0; k < 3; ++k) to->radiance[k] = (float)from->radiance[k];
        if (mcv_emitter_has_surface(from->type)) {
            pack_surface(scene, packed, from, count, next, areas);
            next += to->triangle_count + 1;
        }
        if (from->type == MCV_EMITTER_ENVIRONMENT) {
            result = pack_environment(scene, packed, from, count, next, error);
            next += environment_entries(scene->textures + from->texture);
        }
        prepare_emitter(scene, packed, i, to);
        find_reach(scene, packed, from, to);
        rectangles += mcv_pack_rectangle(scene, packed, to);
        powers[count++] = emitter_power(scene, packed, from);
    }
    if (!failed) {
        double all = 0;
        for (uint32_t i = 0; i < count; ++i) all += powers[i];
        for (uint32_t i = 0; i < count && all > 0; ++i)
            packed->emitters[i].power = (float)(powers[i] / all);
        share_choices(powers, count);
        const double total = mcv_write_cdf(cdf, count, powers);
        for (uint32_t i = 0; i < count; ++i)
            packed->emitters[i].probability = (float)((cdf[i + 1] - cdf[i]) * 0x1p-31);
        if (!(total > 0)) packed->features &= ~(1u << MCV_FEATURE_NEXT_EVENT);
        const bool looks = packed->features >> MCV_FEATURE_NEXT_EVENT & 1;
        packed->features |= feature(MCV_FEATURE_RECTANGLE, looks && rectangles > 0);
        const uint32_t met_by_chance =
            1u << MCV_FEATURE_ENVIRONMENT | 1u << MCV_FEATURE_DIELECTRIC | 1u << MCV_FEATURE_SHEET;
        packed->features |=
            feature(MCV_FEATURE_EARLY_ROULETTE, looks && !(packed->features & met_by_chance));
        packed->features |=
            feature(MCV_FEATURE_REACH, looks && count > 1 && count <= MCV_MOST_REACHING);
    }
    free(powers);
    free(areas);
    if (failed) return mcv_fail(error, MCV_FAILED, "%s: no memory for the emitters", scene->path);
    if (result != MCV_OK) return result;
    packed->light_cdf = (uint32_t)next;
    return mcv_pack_light(scene, packed, cdf + next, error);
}

/* What the scene needs */

static uint32_t find_features(const mcv_scene *scene) {
    uint32_t features = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *instance = &scene->instances[i];
        const mcv_material *material = &scene->materials[instance->material];
        const mcv_dielectric_params *glass =
            material->type == MCV_MATERIAL_DIELECTRIC ? &material->as.dielectric : NULL;
        const bool sheet =
            material->type == MCV_MATERIAL_SHEET || material->type == MCV_MATERIAL_BEAM_SPLITTER;
        features |=
            feature(MCV_FEATURE_DIFFUSE, material->type == MCV_MATERIAL_DIFFUSE) |
            feature(MCV_FEATURE_DIELECTRIC, glass) |
            feature(MCV_FEATURE_TRANSLUCENT, material->type == MCV_MATERIAL_DIFFUSE &&
                                                 largest(material->as.diffuse.transmittance) > 0) |
            feature(MCV_FEATURE_COATING, glass && glass->coating > 0) |
            feature(MCV_FEATURE_DISPERSION, glass && !mcv_is_grey(glass->ior)) |
            feature(MCV_FEATURE_SHEET, sheet) | feature(MCV_FEATURE_SPLIT, sheet || glass) |
            feature(MCV_FEATURE_MIRROR, material->type == MCV_MATERIAL_MIRROR) |
            feature(MCV_FEATURE_GLOSS,
                    mcv_material_is_rough(material) || material->type == MCV_MATERIAL_CONDUCTOR) |
            feature(MCV_FEATURE_RETROREFLECTOR, material->type == MCV_MATERIAL_RETROREFLECTOR) |
            feature(MCV_FEATURE_TEXTURE, material->texture != MCV_NONE ||
                                             mcv_material_surface_texture(material) != MCV_NONE) |
            feature(MCV_FEATURE_NORMALS, scene->meshes[instance->mesh].normals) |
            feature(MCV_FEATURE_ABSORPTION,
                    glass && (glass->absorption[0] > 0 || glass->absorption[1] > 0 ||
                              glass->absorption[2] > 0));
    }
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *emitter = &scene->emitters[i];
        features |=
            feature(MCV_FEATURE_PARALLEL, !isnan(mcv_emitter_half_angle(emitter))) |
            feature(MCV_FEATURE_LIGHT_FIELD, emitter->type == MCV_EMITTER_LIGHT_FIELD_EMITTER) |
            feature(MCV_FEATURE_PROJECTOR, emitter->type == MCV_EMITTER_PROJECTOR) |
            feature(MCV_FEATURE_AREA, emitter->type == MCV_EMITTER_AREA) |
            feature(MCV_FEATURE_ENVIRONMENT, !mcv_is_looked_for(emitter)) |
            feature(MCV_FEATURE_ENVIRONMENT_IMAGE,
                    emitter->type == MCV_EMITTER_ENVIRONMENT && mcv_is_looked_for(emitter)) |
            feature(MCV_FEATURE_BEAM, emitter->type == MCV_EMITTER_COLLIMATED_BEAM) |
            feature(MCV_FEATURE_PUNCTUAL, emitter->type == MCV_EMITTER_POINT ||
                                              emitter->type == MCV_EMITTER_SPOT ||
                                              emitter->type == MCV_EMITTER_DIRECTIONAL) |
            feature(MCV_FEATURE_TEXTURE, emitter->texture != MCV_NONE);
    }
    features |= feature(MCV_FEATURE_SURFACES, scene->solid_count > 0);
    const bool spreads = features & (1u << MCV_FEATURE_DIFFUSE | 1u << MCV_FEATURE_GLOSS |
                                     1u << MCV_FEATURE_RETROREFLECTOR);
    const uint32_t looked_for = 1u << MCV_FEATURE_PARALLEL | 1u << MCV_FEATURE_LIGHT_FIELD |
                                1u << MCV_FEATURE_PROJECTOR | 1u << MCV_FEATURE_AREA |
                                1u << MCV_FEATURE_BEAM | 1u << MCV_FEATURE_PUNCTUAL |
                                1u << MCV_FEATURE_ENVIRONMENT_IMAGE;
    return features | feature(MCV_FEATURE_NEXT_EVENT, spreads && (features & looked_for)) |
           feature(MCV_FEATURE_INTERLEAVE, spreads && scene->triangle_count >= MCV_MANY_TRIANGLES);
}

/* Does one box lie inside of the other, by more than coordinates round? */
static bool well_inside(const mcv_box *inner, const mcv_box *outer) {
    for (int k = 0; k < 3; ++k) {
        const double margin = 1e-6 * (outer->upper[k] - outer->lower[k]);
        if (!(inner->lower[k] > outer->lower[k] + margin &&
              inner->upper[k] < outer->upper[k] - margin))
            return false;
    }
    return true;
}

static bool is_dielectric_body(const mcv_scene *scene, const mcv_instance *instance) {
    return scene->materials[instance->material].type == MCV_MATERIAL_DIELECTRIC;
}

/* Are both of them pieces of exact bodies with one frame, as those of a lens are? */
static bool same_lens(const mcv_scene *scene, const mcv_instance *a, const mcv_instance *b) {
    return scene->meshes[a->mesh].triangle_count == 0 &&
           scene->meshes[b->mesh].triangle_count == 0 &&
           memcmp(&a->to_world, &b->to_world, sizeof a->to_world) == 0;
}

/* Does the outer body's mesh come near the box of one that lies in its own? It does in a vial,
 * about a bubble in a lens it does not. */
static bool comes_near(const mcv_scene *scene, uint32_t outer, const mcv_box *inner) {
    const uint32_t triangles = scene->meshes[scene->instances[outer].mesh].triangle_count;
    for (uint32_t t = 0; t < triangles; ++t) {
        double corners[3][3];
        mcv_box box;
        mcv_scene_corners(scene, outer, t, corners);
        for (int k = 0; k < 3; ++k) {
            const double margin = 1e-6 * (inner->upper[k] - inner->lower[k]);
            box.lower[k] = fmin(corners[0][k], fmin(corners[1][k], corners[2][k])) - margin;
            box.upper[k] = fmax(corners[0][k], fmax(corners[1][k], corners[2][k])) + margin;
        }
        if (overlap(&box, inner)) return true;
    }
    return false;
}

/* May bodies of dielectrics be in contact? Not where their boxes are apart, or one lies within the
 * other, away from its surface. */
static bool may_touch(const mcv_scene *scene, const mcv_box *boxes) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *a = scene->instances + i;
        if (!is_dielectric_body(scene, a)) continue;
        for (uint32_t j = 0; j < i; ++j) {
            const mcv_instance *b = scene->instances + j;
            if (!is_dielectric_body(scene, b) || same_lens(scene, a, b)) continue;
            if (!overlap(boxes + i, boxes + j)) continue;
            if (well_inside(boxes + i, boxes + j)
                    ? comes_near(scene, j, boxes + i)
                    : !well_inside(boxes + j, boxes + i) || comes_near(scene, i, boxes + j))
                return true;
        }
    }
    return false;
}

/* How the tile schedule shades an instance's surface (kernels/schedule/ranges.h), when all else is
 * known. */
static uint32_t shading_of(const mcv_packed *packed, const mcv_device_instance *instance) {
    const mcv_device_material *m = &packed->materials[instance->material];
    const mcv_device_gloss *gloss = packed->gloss ? &packed->gloss[instance->material] : NULL;
    const mcv_device_emitter *e =
        instance->emitter == MCV_NONE ? NULL : packed->emitters + instance->emitter;
    if (m->type == MCV_MATERIAL_ABSORBER && !e) return MCV_SHADED_BLACK;
    if (m->type == MCV_MATERIAL_ABSORBER && packed->emitter_count <= MCV_MOST_LAMPS &&
        e->texture == MCV_NONE && (e->type == MCV_EMITTER_AREA || e->type == MCV_EMITTER_PARALLEL))
        return MCV_SHADED_BLACK + 1 + instance->emitter;
    if (m->texture != MCV_NONE || e) return MCV_SHADED_ALONE;
    if (m->type == MCV_MATERIAL_DIFFUSE) return MCV_SHADED_DIFFUSE;
    if (m->type == MCV_MATERIAL_DIELECTRIC && !m->scattering_sides) return MCV_SHADED_SMOOTH;
    if (!gloss || !m->scattering_sides || m->type == MCV_MATERIAL_RETROREFLECTOR)
        return MCV_SHADED_ALONE;
    return gloss->azimuths == 1 && gloss->roughnesses == 1 && gloss->texture == MCV_NONE
               ? MCV_SHADED_GLOSSY
               : MCV_SHADED_ALONE;
}

static mcv_result pack_all(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                           mcv_error *error) {
    uint64_t vertices = 0;
    bool failed = false;
    packed->boxes = allocate(scene->instance_count, sizeof *packed->boxes, &failed);
    if (failed) return mcv_fail(error, MCV_FAILED, "%s: no memory to place the scene", scene->path);
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        vertices += scene->meshes[scene->instances[i].mesh].vertex_count;
        mcv_scene_box(scene, i, packed->boxes[i].lower, packed->boxes[i].upper);
    }
    /* The kernels count the coordinates of the vertices in 32 bits. */
    if (vertices > UINT32_MAX / 3) {
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: nodes: %llu vertices after placing all meshes, at most %u can be rendered",
            scene->path, (unsigned long long)vertices, UINT32_MAX / 3);
    }
    packed->features =
        find_features(scene) | feature(MCV_FEATURE_CONTACT, may_touch(scene, packed->boxes));
    packed->channels = mcv_scene_channels(scene);
    packed->vertex_count = (uint32_t)vertices;
    packed->triangle_count = scene->triangle_count;
    packed->instance_count = scene->instance_count;
    packed->material_count = scene->material_count;
    packed->texture_count = scene->texture_count;
    packed->texel_count = 256;
    packed->texcoord_sets = 1;
    for (uint32_t i = 0; i < scene->texture_count; ++i) {
        const mcv_texture *texture = &scene->textures[i];
        if (!texture->shares_pixels)
            packed->texel_count += texel_words(texture) * texture->width * texture->height;
        if (packed->features >> MCV_FEATURE_TEXTURE & 1 && texture->texcoord_set > 0)
            packed->texcoord_sets = 2;
    }
    packed->cdf_count = 2;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *emitter = &scene->emitters[i];
        if (!mcv_is_looked_for(emitter)) {
            for (int k = 0; k < 3; ++k) packed->environment[k] = (float)emitter->radiance[k];
            continue;
        }
        ++packed->emitter_count;
        packed->cdf_count += 2;
        if (emitter->type == MCV_EMITTER_ENVIRONMENT)
            packed->cdf_count += environment_entries(scene->textures + emitter->texture);
        if (mcv_emitter_has_surface(emitter->type))
            packed->cdf_count +=
                1 + scene->meshes[scene->instances[emitter->instance].mesh].triangle_count;
    }
    find_centre(packed->boxes, scene->instance_count, packed->centre);

    packed->positions = allocate(3 * vertices, sizeof(float), &failed);
    if (packed->features >> MCV_FEATURE_NORMALS & 1)
        packed->normals = allocate(3 * vertices, sizeof(float), &failed);
    if (packed->features >> MCV_FEATURE_TEXTURE & 1)
        packed->texcoords = allocate(2 * packed->texcoord_sets * vertices, sizeof(float), &failed);
    if (packed->features >> MCV_FEATURE_GLOSS & 1)
        packed->gloss = allocate(scene->material_count, sizeof *packed->gloss, &failed);
    if (mcv_scene_has_directions(scene))
        packed->tangents = allocate(4 * vertices, sizeof(float), &failed);
    packed->indices = allocate(3 * (size_t)scene->triangle_count, sizeof(uint32_t), &failed);
    packed->triangles = allocate(4 * (size_t)scene->triangle_count, sizeof(uint32_t), &failed);
    packed->instances = allocate(scene->instance_count, sizeof *packed->instances, &failed);
    packed->materials = allocate(scene->material_count, sizeof *packed->materials, &failed);
    packed->emitters = allocate(packed->emitter_count, sizeof *packed->emitters, &failed);
    packed->emitter_cdf = allocate(packed->cdf_count, sizeof(uint32_t), &failed);
    packed->textures = allocate(scene->texture_count, sizeof *packed->textures, &failed);
    packed->solid_count = scene->solid_count;
    if (scene->solid_count > 0)
        packed->solids = allocate(scene->solid_count, sizeof *packed->solids, &failed);
    packed->texels = allocate(packed->texel_count, sizeof(uint32_t), &failed);
    if (failed) {
        return mcv_fail(error, MCV_FAILED, "%s: no memory to place %u triangles with %llu vertices",
                        scene->path, scene->triangle_count, (unsigned long long)vertices);
    }

    uint32_t first_vertex = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *instance = &scene->instances[i];
        const mcv_mesh *mesh = &scene->meshes[instance->mesh];
        packed->instances[i] = (mcv_device_instance){.material = instance->material,
                                                     .emitter = MCV_NONE,
                                                     .first_triangle = instance->first_triangle};
        pack_instance(scene, packed, i, first_vertex);
        first_vertex += mesh->vertex_count;
    }
    for (uint32_t i = 0; i < scene->material_count; ++i)
        packed->materials[i] = pack_material(&scene->materials[i]);
    pack_textures(scene, packed);
    if (packed->gloss) MCV_TRY(mcv_pack_gloss(scene, earlier, packed, error));
    if (packed->solids) mcv_pack_solids(scene, packed);
    MCV_TRY(assign_media(scene, earlier, packed, error));
    MCV_TRY(pack_emitters(scene, packed, error));
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        packed->instances[i].shading = shading_of(packed, &packed->instances[i]);
    return MCV_OK;
}

mcv_result mcv_pack(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                    mcv_error *error) {
    memset(packed, 0, sizeof *packed);
    const mcv_result result = pack_all(scene, earlier, packed, error);
    if (result != MCV_OK) mcv_packed_free(packed);
    return result;
}

void mcv_pack_placement(const mcv_packed *packed, const mcv_transform *to_world,
                        float placement[12], float rest[12]) {
    const double *m = to_world->m;
    for (int r = 0; r < 3; ++r) {
        /* The optical axis is the node's -z. */
        const double row[4] = {m[3 * r], m[3 * r + 1], -m[3 * r + 2], m[9 + r] - packed->centre[r]};
        for (int k = 0; k < 4; ++k) {
            const int to = k < 3 ? 3 * r + k : 9 + r;
            placement[to] = (float)row[k];
            rest[to] = (float)(row[k] - placement[to]);
        }
    }
}
