/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/emitters.h"

#include "scene/params.h"

mcv_result mcv_emitter_check(const mcv_emitter *emitter, const mcv_place *place, mcv_error *error) {
    if (emitter->type == MCV_EMITTER_PARALLEL && emitter->as.parallel.halfAngle == 0) {
        const mcv_place here = mcv_place_key(place, "halfAngle");
        return mcv_fail_at(&here, error, "0 would be a collimated beam, which no ray of sight can meet by chance: give an angle above 0");
    }
    return mcv_params_check(mcv_emitter_table(emitter->type), &emitter->as, place, error);
}

double *mcv_emitter_parameter(mcv_emitter *emitter, const char *key) {
    const mcv_param_table table = mcv_emitter_table(emitter->type);
    for (size_t i = 0; i < table.count; ++i)
        if (strcmp(table.params[i].key, key) == 0) return (double *)(void *)((char *)&emitter->as + table.params[i].offset);
    return NULL;
}

double mcv_emitter_solid_angle(const mcv_emitter *emitter) {
    if (emitter->type == MCV_EMITTER_AREA) return 2 * M_PI;
    if (emitter->type == MCV_EMITTER_ENVIRONMENT) return 4 * M_PI;
    const double s = sin(emitter->as.parallel.halfAngle / 2);
    return 4 * M_PI * s * s;
}

double mcv_emitter_projected_solid_angle(const mcv_emitter *emitter) {
    if (emitter->type != MCV_EMITTER_PARALLEL) return M_PI;
    const double s = sin(emitter->as.parallel.halfAngle);
    return M_PI * s * s;
}

mcv_result mcv_emitter_resolve(mcv_emitter *emitter, const mcv_place *place, mcv_error *error) {
    const double *radiance = mcv_emitter_parameter(emitter, "radiance");
    const double *power = mcv_emitter_parameter(emitter, "power");
    const bool has_power = power && !isnan(power[0]);
    if (isnan(radiance[0]) && !has_power) return mcv_fail_at(place, error, "needs radiance [W/(m² sr)] or power [W]");
    if (!isnan(radiance[0]) && has_power)
        return mcv_fail_at(place, error, "has both radiance %g and power %g: give one, the other follows", radiance[0], power[0]);
    for (int i = 0; i < 3; ++i)
        emitter->radiance[i] = has_power ? power[i] / (mcv_emitter_projected_solid_angle(emitter) * emitter->area) : radiance[i];
    if (!has_power || isfinite(emitter->radiance[0] + emitter->radiance[1] + emitter->radiance[2])) return MCV_OK;
    return mcv_fail_at(place, error, "an area of %g m² with this cone is too small for a power of %g W", emitter->area, power[0]);
}

/* Do all vertices of all triangles have the same normal? */
static bool common_normal(const mcv_scene *scene, uint32_t instance, double normal[3]) {
    const uint32_t count = scene->meshes[scene->instances[instance].mesh].triangle_count;
    for (uint32_t t = 0; t < count; ++t) {
        double normals[3][3];
        mcv_scene_vertex_normals(scene, instance, t, normals);
        if (t == 0) memcpy(normal, normals[0], sizeof normals[0]);
        for (int corner = 0; corner < 3; ++corner) /* The device holds the axis in float32: what rounds to it is it. */
            for (int i = 0; i < 3; ++i)
                if ((float)normals[corner][i] != (float)normal[i]) return false;
    }
    return count > 0;
}

void mcv_parallel_prepare(const mcv_scene *scene, uint32_t index, mcv_parallel *device) {
    const mcv_emitter *emitter = scene->emitters + index;
    const double beta = emitter->as.parallel.halfAngle;
    double axis[3] = {0, 0, 0};
    const bool common = common_normal(scene, emitter->instance, axis);
    *device = (mcv_parallel){
        .tangent_squared = (float)(tan(beta) * tan(beta)),
        .sin_half = (float)sin(beta / 2),
        .solid_angle = (float)mcv_emitter_solid_angle(emitter),
        .from_receiver = common && beta <= M_PI / 6,
        .axis = {(float)axis[0], (float)axis[1], (float)axis[2]},
    };
}
