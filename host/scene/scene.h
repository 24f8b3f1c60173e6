/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The scene as the host works with it: what the file says, in SI units and double, before any
 * re-centring or packing for a device. The loader (host/loader/load.c) makes it; the OpenCL
 * renderer, the reference renderer and `mcvisi check` read it.
 *
 * Everything inside is owned by the scene and freed by mcv_scene_free. Tests may build one by hand
 * with mcv_scene_new and the mcv_scene_add_… functions, which copy what they are given.
 */
#ifndef MCVISI_HOST_SCENE_SCENE_H
#define MCVISI_HOST_SCENE_SCENE_H

#include "mcvisi/elements.h"
#include "mcvisi/mcvisi.h"
#include "mcvisi/params.h"

#include "mcvisi/emitters/area.h"
#include "mcvisi/emitters/collimated_beam.h"
#include "mcvisi/emitters/directional.h"
#include "mcvisi/emitters/environment.h"
#include "mcvisi/emitters/light_field.h"
#include "mcvisi/emitters/parallel.h"
#include "mcvisi/emitters/point.h"
#include "mcvisi/emitters/projector.h"
#include "mcvisi/emitters/spot.h"
#include "mcvisi/emitters/telecentric_projector.h"
#include "mcvisi/materials/absorber.h"
#include "mcvisi/materials/beam_splitter.h"
#include "mcvisi/materials/conductor.h"
#include "mcvisi/materials/dielectric.h"
#include "mcvisi/materials/diffuse.h"
#include "mcvisi/materials/metallic_roughness.h"
#include "mcvisi/materials/mirror.h"
#include "mcvisi/materials/retroreflector.h"
#include "mcvisi/materials/sheet.h"
#include "mcvisi/pattern.h"
#include "mcvisi/presets/bar.h"
#include "mcvisi/presets/coaxial.h"
#include "mcvisi/presets/dome.h"
#include "mcvisi/presets/ring.h"
#include "mcvisi/sensors/light_field.h"
#include "mcvisi/sensors/pinhole.h"
#include "mcvisi/sensors/telecentric.h"
#include "mcvisi/sensors/thin_lens.h"
#include "mcvisi/surfaces/surfaces.h"

/* The parameter structs mcv_<name>_params; the absorber has no parameters and C no empty structs.
 */
#define MCV_X(name, key, NAME) \
    typedef struct mcv_##name##_params { \
        MCV_##NAME##_PARAMS(MCV_DEFINE_FIELD) char end; \
    } mcv_##name##_params;
MCV_SENSORS(MCV_X)
MCV_EMITTERS(MCV_X)
MCV_PRESETS(MCV_X)
MCV_MATERIALS(MCV_X)
#undef MCV_X

/* Row-major affine map of points: world = m[0..8] p + m[9..11]. */
typedef struct mcv_transform {
    double m[12];
} mcv_transform;

/* An image, row 0 on top: 8-bit RGBA whose values are sRGB-encoded (glTF), or linear values
 * (OpenEXR). */
typedef struct mcv_texture {
    char *name;
    uint32_t width, height;
    uint32_t wrap_s, wrap_t; /* glTF: 10497 repeat, 33071 clamp to edge, 33648 mirrored repeat */
    bool nearest;            /* magnification filter; otherwise bilinear */
    uint8_t *rgba;           /* or NULL: then linear */
    float *linear;           /* R G B, finite, 0 or more */
    bool is_data;            /* no colour: roughness and metallic */
    bool shares_pixels;    /* they belong to a texture before this one, which is placed otherwise */
    uint32_t texcoord_set; /* of the mesh: 0 or 1 */
    bool is_transformed;   /* by KHR_texture_transform; where not, the image lies as the set says */
    double transform[6]; /* the place in the image: t[0] u + t[1] v + t[2] across, t[3] u + t[4] v +
                            t[5] down */
} mcv_texture;

typedef struct mcv_material {
    char *name;
    uint32_t type;    /* MCV_MATERIAL_… */
    uint32_t texture; /* multiplies reflectance or transmittance, or MCV_NONE */
    bool by_name; /* a conductor whose n and k come from its metal and the scene's wavelengths */
    double ior_d; /* of a dielectric with an Abbe number: its index at the d line */
    uint32_t surface_texture; /* of a metallicRoughness: linear, multiplies roughness (green) and
                                 metallic (blue), or MCV_NONE */
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_MATERIALS(MCV_X)
#undef MCV_X
    } as;
} mcv_material;

/* Triangles in their node's frame, as stored in the file (float32), shared by instances. */
typedef struct mcv_mesh {
    char *name;
    uint32_t vertex_count, triangle_count;
    float *positions;  /* 3 per vertex [m] */
    float *normals;    /* 3 per vertex, unit, or NULL: flat */
    float *texcoords;  /* 2 per vertex (TEXCOORD_0), or NULL */
    float *texcoords1; /* the same of TEXCOORD_1 */
    float *tangents;   /* 4 per vertex: direction and the bitangent's sign; NULL where no material
                          asks for them */
    uint32_t *indices; /* 3 per triangle */
} mcv_mesh;

/* A mesh placed in the world. Its triangles have the global numbers first_triangle … first_triangle
 * + triangle_count - 1. */
typedef struct mcv_instance {
    char *name; /* of the node */
    uint32_t mesh, material;
    uint32_t emitter; /* index into emitters, or MCV_NONE */
    uint32_t first_triangle;
    mcv_transform
        to_world; /* may mirror: then the winding turns, the normal stays on the front side */
} mcv_instance;

/* A surface of revolution about z, or one along x, within the side of its solid
 * (mcvisi/surfaces/surfaces.h). */
typedef struct mcv_cap {
    double z;         /* of the vertex [m] */
    double curvature; /* [1/m] */
    double conic;
    double asphere[MCV_ASPHERE_TERMS]; /* of r^4, r^6 … [m^(1-i)] */
    bool cylindrical;
} mcv_cap;

/*
 * A body with exact surfaces. Its instances' meshes have the vertices of its box and no triangles.
 * Its pieces have the global numbers triangle_count + 3 solid + piece, after those of all
 * triangles.
 */
typedef struct mcv_solid {
    uint32_t side;   /* MCV_SIDE_… (mcvisi/surfaces/solid.h) */
    double radius;   /* of the side [m] */
    double half[2];  /* of a box: half its size along x and y [m] */
    double hole;     /* of an open surface: the radius of its hole [m] */
    mcv_cap caps[2]; /* the first below, the second above; a sphere has none, an open surface only
                        the first */
    bool cemented;   /* its first cap is the second one of the solid before, with the same frame */
    uint32_t instances[3];  /* of its pieces: first cap, second cap, side */
    mcv_transform to_world; /* rigid */
} mcv_solid;

/*
 * A named node, of the file or of one of its assets: its axes without scale (they may mirror) and
 * its origin in the world. Lengths along them are metres of the scene, whatever the node or its
 * asset is scaled by.
 */
typedef struct mcv_placement {
    char *name;
    bool of_asset;
    mcv_transform to_world;
} mcv_placement;

/* An emitter with a surface belongs to exactly one instance, any other to none. */
typedef struct mcv_emitter {
    char *name;
    uint32_t type;      /* MCV_EMITTER_… */
    uint32_t instance;  /* whose triangles emit, or MCV_NONE */
    uint32_t texture;   /* multiplies the radiance (glTF emissive texture, parameter `image`), or
                           MCV_NONE */
    double radiance[3]; /* resolved from it or power [W/(m² sr)]; an irradiance [W/m²] or intensity
                           [W/sr] where its type has that */
    double area;        /* of the instance in the world [m²]; 0 without one */
    bool bare_angle;    /* its halfAngle or outerConeAngle was given as a number without a unit */
    mcv_transform to_world; /* where there is no instance: the node's rotation and translation; it
                               shines along -z */
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_EMITTERS(MCV_X)
#undef MCV_X
    } as;
} mcv_emitter;

typedef struct mcv_sensor {
    char *name;
    uint32_t type;          /* MCV_SENSOR_… */
    mcv_transform to_world; /* rotation and translation of the node, scale removed; the sensor looks
                               along the node's -z, +y is up */
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_SENSORS(MCV_X)
#undef MCV_X
    } as; /* resolved: the report's parameters are all set */
} mcv_sensor;

/* What microfacets lose is tabled for one channel's indices: green's. */
enum { MCV_ALBEDO_CHANNEL = 1 };

/* A scene's wavelengths lie between [m]. */
#define MCV_LEAST_WAVELENGTH 1e-7
#define MCV_LARGEST_WAVELENGTH 1e-4

typedef struct mcv_scene {
    char *path; /* of the file, for messages */
    uint32_t texture_count, material_count, mesh_count, instance_count, emitter_count, sensor_count;
    uint32_t triangle_count; /* of all instances */
    uint32_t solid_count;
    mcv_texture *textures;
    mcv_material *materials;
    mcv_mesh *meshes;
    mcv_instance *instances;
    mcv_emitter *emitters;
    mcv_sensor *sensors;
    mcv_solid *solids;
    mcv_placement *frames;
    uint32_t frame_count;
    double wavelengths[3]; /* of the channels [m]; 0: the defaults */
    uint64_t fingerprint;  /* of all files that were read, in their order */
    char **warnings;       /* sentences for the user */
    uint32_t warning_count;
} mcv_scene;

void mcv_scene_free(mcv_scene *scene);

/* An empty scene to add to. NULL without memory. */
mcv_scene *mcv_scene_new(const char *path);

/*
 * Each copies its argument (arrays, names and all) and appends it; the new element has the index
 * count - 1. add_instance sets first_triangle and triangle_count; add_emitter sets area, resolves
 * radiance or power, takes texture from the parameter `image` where it has one, and marks its
 * instance; add_sensor resolves the parameters. Bad values fail as they would from a file.
 */
mcv_result mcv_scene_add_texture(mcv_scene *scene, const mcv_texture *texture, mcv_error *error);
mcv_result mcv_scene_add_material(mcv_scene *scene, const mcv_material *material, mcv_error *error);
mcv_result mcv_scene_add_mesh(mcv_scene *scene, const mcv_mesh *mesh, mcv_error *error);
mcv_result mcv_scene_add_instance(mcv_scene *scene, const mcv_instance *instance, mcv_error *error);
mcv_result mcv_scene_add_emitter(mcv_scene *scene, const mcv_emitter *emitter, mcv_error *error);
mcv_result mcv_scene_add_sensor(mcv_scene *scene, const mcv_sensor *sensor, mcv_error *error);

/* `to_world` may scale; a node without a name or with a vanished axis is left out. MCV_FAILED
 * without memory. */
mcv_result mcv_scene_add_frame(mcv_scene *scene, const char *name, bool of_asset,
                               const mcv_transform *to_world, mcv_error *error);

/* Makes its instances: `body` is the material of the caps, `rim` that of the side (the same: one
 * instance). */
mcv_result mcv_scene_add_solid(mcv_scene *scene, const mcv_solid *solid, const char *name,
                               uint32_t body, uint32_t rim, mcv_error *error);
/* A mesh without tangents gets them, by its texture coordinates or else along its x axis, when a
 * material is put on it that needs them. */
mcv_result mcv_scene_warn(mcv_scene *scene, mcv_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* All parameters of `params` at their defaults (NaN where unset), for hand-made elements: table
 * from mcv_<kind>_table(type). */
typedef struct mcv_param_table {
    const mcv_param *params;
    size_t count;
    size_t struct_size;
} mcv_param_table;
mcv_param_table mcv_sensor_table(uint32_t type);
mcv_param_table mcv_emitter_table(uint32_t type); /* presets too */
mcv_param_table mcv_material_table(uint32_t type);
void mcv_params_set_defaults(mcv_param_table table, void *params);
/* A parameter's field of params, or NULL where the table has none of that name. */
void *mcv_params_find(mcv_param_table table, const char *key, const void *params);

/*
 * The wavelength that a channel stands for [m]. Unless the scene says, a grey scene is rendered at
 * the d line of helium, 587.6 nm, and the channels of a coloured one at 611.4, 549.1 and 464.2 nm.
 */
double mcv_scene_wavelength(const mcv_scene *scene, int channel);

/* Sets n and k of conductors given by name. Call it when all else is in the scene: what it holds
 * decides whether it is grey. */
void mcv_scene_settle_spectra(mcv_scene *scene);

/* The index of a glass (an option of `glass`) at a wavelength [m]. */
double mcv_glass_index(int glass, double wavelength);

/* The index at a wavelength [m] by Cauchy's first two terms from n_d and Abbe's number; at least 1.
 */
double mcv_cauchy_index(double n_d, double abbe_number, double wavelength);

/* n and k of a metal (an option of `metal`), between the wavelengths of its table by line, beyond
 * them at their ends. */
void mcv_metal_index(int metal, double wavelength, double *n, double *k);

/* The microfacets of a material; all 0 where it is smooth or has none. */
typedef struct mcv_roughness {
    double roughness;  /* α is its square */
    double anisotropy; /* 0 … 1 */
    double rotation;   /* of the rougher direction from the tangent, counter-clockwise [rad] */
} mcv_roughness;
mcv_roughness mcv_material_roughness(const mcv_material *material);
bool mcv_material_is_rough(const mcv_material *material); /* it consists of microfacets */
double mcv_material_coating(const mcv_material *material,
                            double outside); /* its R0 against a medium of an index, or 0: none */
uint32_t mcv_material_surface_texture(
    const mcv_material *material);                     /* of roughness and metallic, or MCV_NONE */
bool mcv_scene_has_directions(const mcv_scene *scene); /* whether a material is anisotropic */

/* Pixels of the sensor's image. */
void mcv_sensor_film_size(const mcv_sensor *sensor, uint32_t *width, uint32_t *height);

/* The linear value of a byte encoded as IEC 61966-2-1 says. */
double mcv_srgb_decode(uint8_t value);

/* Linear R, G, B of a texture's pixel; `decoded` holds mcv_srgb_decode of all bytes. */
void mcv_texture_value(const mcv_texture *texture, const double decoded[256], uint32_t column,
                       uint32_t row, double rgb[3]);
void mcv_srgb_table(double decoded[256]);

bool mcv_is_grey(const double spectrum[3]);

/* The number of channels that the spectra need: 1 if all are grey and no texture is coloured,
 * else 3. */
uint32_t mcv_scene_channels(const mcv_scene *scene);

/* World geometry in double. `global` is a triangle's number; `instance` gets its instance. Corners
 * run counter-clockwise from the front. */
uint32_t mcv_scene_instance_of(const mcv_scene *scene, uint32_t global);
void mcv_scene_triangle(const mcv_scene *scene, uint32_t instance, uint32_t local,
                        uint32_t vertices[3]); /* of the mesh, in that order */
void mcv_scene_vertex(const mcv_scene *scene, uint32_t instance, uint32_t vertex, double world[3]);
void mcv_scene_box(const mcv_scene *scene, uint32_t instance, double lower[3],
                   double upper[3]); /* without vertices: lower > upper */
void mcv_scene_corners(const mcv_scene *scene, uint32_t instance, uint32_t local,
                       double corners[3][3]);
void mcv_scene_face_normal(const mcv_scene *scene, uint32_t instance, uint32_t local,
                           double normal[3]); /* twice the area long */
void mcv_scene_vertex_normals(const mcv_scene *scene, uint32_t instance, uint32_t local,
                              double normals[3][3]); /* unit; flat meshes: the face's */
/* A vertex's tangent in the world, not normalised, and the sign of its bitangent: normal x tangent.
 */
void mcv_scene_tangent(const mcv_scene *scene, uint32_t instance, uint32_t vertex,
                       double tangent[4]);
void mcv_transform_point(const mcv_transform *transform, const double p[3], double out[3]);
void mcv_transform_vector(const mcv_transform *transform, const double v[3], double out[3]);
mcv_transform mcv_transform_compose(const mcv_transform *outer, const mcv_transform *inner);
mcv_transform mcv_transform_identity(void);

#endif
