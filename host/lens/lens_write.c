/* SPDX-License-Identifier: Apache-2.0 */
/* A lens prescription as a glTF document with MCVISI_surfaces. */
#include "lens/lens.h"

#include <math.h>

#include "scene/params.h"

static json_t *write_material(const mcv_lens_glass *glass) {
    json_t *material = glass->catalogue > 0
                           ? json_pack("{s:s, s:s}", "type", "dielectric", "glass",
                                       mcv_param_options("glass")[glass->catalogue])
                           : json_pack("{s:s, s:f}", "type", "dielectric", "ior", glass->index);
    if (glass->catalogue == 0 && glass->abbe > 0)
        json_object_set_new(material, "abbeNumber", json_real(glass->abbe));
    return json_pack("{s:s, s:{s:o}}", "name", glass->name, "extensions", "MCVISI_materials",
                     material);
}

static json_t *write_surface(const mcv_lens *l, const mcv_lens_surface *s, double thickness,
                             int material) {
    json_t *out = json_object();
    int terms = 0;
    if (fabs(s->curvature) > 1e-15 * l->unit)
        json_object_set_new(out, "radius", json_real(l->unit / s->curvature)); /* else a plane */
    if (s->conic != 0) json_object_set_new(out, "conic", json_real(s->conic));
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i)
        if (s->asphere[i] != 0) terms = i + 1;
    if (terms > 0) {
        json_t *list = json_array();
        for (int i = 0; i < terms; ++i)
            json_array_append_new(list, json_real(s->asphere[i] * pow(l->unit, -2 * i - 3)));
        json_object_set_new(out, "asphere", list);
    }
    json_object_set_new(out, "semiDiameter", json_real(s->semi_diameter * l->unit));
    if (isfinite(thickness)) json_object_set_new(out, "thickness", json_real(thickness * l->unit));
    if (material >= 0) json_object_set_new(out, "material", json_integer(material));
    return out;
}

json_t *mcv_lens_write(const mcv_lens *l, int first, int end) {
    json_t *materials = json_array(), *surfaces = json_array(), *bodies = json_array(),
           *nodes = json_array(), *children = json_array();
    const char *name = *l->name ? l->name : "lens";
    double z = 0;
    for (int i = first; !*l->surfaces[i].glass.name; ++i) z -= l->surfaces[i].thickness;
    for (int i = first; i < end; ++i) {
        const mcv_lens_surface *s = l->surfaces + i;
        const bool of_body = mcv_lens_bounds_glass(l, i), glass = *s->glass.name;
        if (i == l->stop && !of_body) {
            json_array_append_new(
                bodies, json_pack("{s:s, s:s, s:f, s:f, s:s}", "name", "stop", "type", "disc",
                                  "radius", 3 * s->semi_diameter * l->unit, "holeRadius",
                                  s->semi_diameter * l->unit, "material", "black"));
            json_array_append_new(children,
                                  json_integer((json_int_t)json_array_size(children) + 1));
            json_array_append_new(nodes, json_pack("{s:s, s:[f,f,f], s:{s:{s:i}}}", "name", "stop",
                                                   "translation", 0.0, 0.0, z * l->unit,
                                                   "extensions", "MCVISI_surfaces", "surface",
                                                   (int)json_array_size(bodies)));
        }
        if (of_body) {
            double thickness = s->thickness;
            for (int k = i + 1; !glass && k < end && !*l->surfaces[k].glass.name; ++k)
                thickness += l->surfaces[k].thickness; /* past dummies */
            json_array_append_new(
                surfaces,
                write_surface(l, s, thickness, glass ? (int)json_array_size(materials) : -1));
            if (glass) json_array_append_new(materials, write_material(&s->glass));
        }
        z += s->thickness;
    }
    json_array_append_new(materials, json_pack("{s:s, s:{s:{s:s}}}", "name", "black", "extensions",
                                               "MCVISI_materials", "type", "absorber"));
    json_array_insert_new(
        bodies, 0,
        json_pack("{s:s, s:s, s:o}", "name", name, "type", "lens", "surfaces", surfaces));
    json_t *root = json_pack("{s:s, s:{s:{s:i}}}", "name", name, "extensions", "MCVISI_surfaces",
                             "surface", 0);
    if (json_array_size(children) > 0)
        json_object_set_new(root, "children", children);
    else
        json_decref(children);
    json_array_insert_new(nodes, 0, root);
    return json_pack("{s:{s:s, s:s}, s:i, s:[{s:[i]}], s:[s,s,s], s:{s:{s:o}, s:{s:f}}, s:o, s:o}",
                     "asset", "version", "2.0", "generator", "mcvisi import", "scene", 0, "scenes",
                     "nodes", 0, "extensionsUsed", "MCVISI_surfaces", "MCVISI_materials",
                     "MCVISI_spectrum", "extensions", "MCVISI_surfaces", "surfaces", bodies,
                     "MCVISI_spectrum", "wavelengths", l->wavelength, "materials", materials,
                     "nodes", nodes);
}
