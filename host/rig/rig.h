/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A rig around a part: standard optics that frame it and a light in a realistic place, as a scene
 * to read and edit. The user's wishes are kept; the rest is chosen for the part's size.
 */
#ifndef MCVISI_HOST_RIG_RIG_H
#define MCVISI_HOST_RIG_RIG_H

#include "core/error.h"

/* X(NAME, "word"): kinds of rigs. TRANSPARENT is the report's experiment (section 5): light field
 * camera and parallel panel. LASER is a triangulation head: a laser line along the view, and a thin
 * lens camera MCV_RIG_ANGLE aside, with a tilted film. */
#define MCV_RIG_KINDS(X) \
    X(TELECENTRIC, "telecentric") \
    X(ENTOCENTRIC, "entocentric") \
    X(LIGHT_FIELD, "lightfield") X(TRANSPARENT, "transparent") X(LASER, "laser")

/* Angle between camera and laser of a triangulation head [degrees]. */
#define MCV_RIG_ANGLE 30
#define MCV_RIG_WAVELENGTH 660e-9 /* of its laser [m] */

/* Kinds of light. The first one is the camera's default: a ring, or a light behind the part for
 * telecentric and transparent. The last one is that of a triangulation head alone. */
#define MCV_RIG_LIGHTS(X) \
    X(AUTO, "auto") \
    X(BACKLIGHT, "backlight") \
    X(RING, "ring") \
    X(DARK_FIELD, "darkfield") X(COAXIAL, "coaxial") X(DOME, "dome") X(LASER, "laser")

enum {
#define MCV_X(NAME, word) MCV_RIG_##NAME,
    MCV_RIG_KINDS(MCV_X) MCV_RIG_KIND_COUNT
#undef MCV_X
};
enum {
#define MCV_X(NAME, word) MCV_RIG_LIGHT_##NAME,
    MCV_RIG_LIGHTS(MCV_X) MCV_RIG_LIGHT_COUNT
#undef MCV_X
};
extern const char *const mcv_rig_kinds[MCV_RIG_KIND_COUNT];
extern const char *const mcv_rig_lights[MCV_RIG_LIGHT_COUNT];

/* What the user wishes; NULL and 0: chosen. Lengths in metres. */
typedef struct mcv_rig_wishes {
    int kind, light;
    const char *part;     /* a .stl, .glb or .gltf file */
    const char *unit;     /* unit of its lengths, as in MCVISI_assets; required for .stl */
    const char *material; /* a metal, a glass or a type of material that replaces the part's own */
    const char *view; /* front, back, left, right, top, bottom (+z, -z, -x, +x, +y, -y), or X,Y,Z:
                         the side that faces the camera */
    uint32_t resolution[2]; /* pixels of the film; macro pixels of a light field camera */
    double pixel_size, focal_length, magnification, f_number, working_distance;
    double field_of_view; /* width, in the plane in focus */
} mcv_rig_wishes;

/* The light before or behind the part. Fields that its kind does not have are 0. */
typedef struct mcv_rig_light {
    int type;          /* MCV_RIG_LIGHT_…, not AUTO */
    double distance;   /* from the part's middle towards the camera; of a backlight away from it */
    double size[2];    /* of a laser: the line's thickness */
    double half_angle; /* of a laser: of its fan [degrees] */
    double inner, outer; /* diameters */
    double tilt;         /* [degrees] */
    double reach;        /* extent towards the camera */
} mcv_rig_light;

typedef struct mcv_rig_design {
    mcv_rig_wishes wishes;
    bool stl;
    bool passes_light;         /* a material of the part's own does */
    bool has_normals;          /* a mesh of the part does */
    double lower[3], upper[3]; /* the part's box */
    uint32_t triangles;
    double centre[3], across[2],
        depth; /* of the part, as the camera sees it: the longer side is horizontal */
    double azimuth, elevation, roll; /* of the camera, or of the laser [degrees] */
    uint32_t pixels[2], directions;  /* of the film; of a macro pixel, 1 without */
    double pixel;
    double magnification, focal_length, working_distance, f_number, field[2];
    mcv_rig_light light;
    char material[160]; /* MCVISI_materials of the part, as JSON; empty: its own */
    double crease;      /* angle of its vertex normals [degrees]; 0: those of its file */
} mcv_rig_design;

/*
 * Reads the part and chooses. MCV_USAGE for contradictory wishes, MCV_BAD_INPUT for a part that
 * cannot be read or that no standard lens frames.
 */
mcv_result mcv_rig_choose(const mcv_rig_wishes *wishes, mcv_rig_design *rig, mcv_error *error);

/* light.c: the light for the chosen camera. */
void mcv_rig_choose_light(mcv_rig_design *rig);

/* The diameter of the view, at a distance from the plane in focus towards the camera (negative:
 * behind it); and its width or height. */
double mcv_rig_view(const mcv_rig_design *rig, double distance);
double mcv_rig_view_side(const mcv_rig_design *rig, int axis, double distance);

/* The next number of the standard series (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 of each decade) at or
 * above x, or at or below it. */
double mcv_rig_usual(double x, bool above);

/*
 * write.c: writes the rig. The part must lie in the rig's folder or below it. An existing file with
 * other contents is replaced only with `force` (MCV_USAGE otherwise).
 */
mcv_result mcv_rig_write(const mcv_rig_design *rig, const char *path, bool force, mcv_error *error);

/* write.c: the same as a text in memory, which the caller frees; `uri` is the part's path from the
 * rig's folder. */
mcv_result mcv_rig_text(const mcv_rig_design *rig, const char *uri, char **text, size_t *size,
                        mcv_error *error);

/* "12.5mm": the length with this many digits, in a suitable unit. At most three results can be used
 * at a time. */
const char *mcv_rig_length(double metres, int digits);

#endif
