/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The scene on the host: the contents of the file in SI units and double, before any re-centring or
 * packing for a device. The loader (loader/load.h) makes it. The OpenCL renderer, the reference
 * renderer and `mcvisi check` read it.
 *
 * The scene owns everything inside; mcv_scene_free frees it. Tests may build one by hand with
 * mcv_scene_new and the mcv_scene_add_… functions, which copy their arguments.
 */
#ifndef MCVISI_HOST_SCENE_SCENE_H
#define MCVISI_HOST_SCENE_SCENE_H

#include "core/json_path.h"
#include "scene/elements.h"
#include "scene/transform.h"

/* An image, row 0 on top: 8-bit RGBA with sRGB encoding (glTF), or linear values (OpenEXR). */
typedef struct mcv_texture {
    char *name;
    uint32_t width, height;
    uint32_t wrap_s, wrap_t; /* glTF: 10497 repeat, 33071 clamp to edge, 33648 mirrored repeat */
    bool nearest;            /* magnification filter; otherwise bilinear */
    uint8_t *rgba;           /* or NULL: then linear */
    float *linear;           /* R G B, finite, 0 or more */
    bool is_data;            /* not a colour: roughness and metallic */
    bool shares_pixels;      /* the pixels belong to an earlier texture with another transform */
    uint32_t texcoord_set;   /* of the mesh: 0 or 1 */
    bool is_transformed;     /* has a KHR_texture_transform */
    double transform[6]; /* the position in the image: t[0] u + t[1] v + t[2] across, t[3] u + t[4]
                            v + t[5] down */
} mcv_texture;

typedef struct mcv_material {
    char *name;
    uint32_t type;    /* MCV_MATERIAL_… */
    uint32_t texture; /* multiplies reflectance or transmittance, or MCV_NONE */
    bool by_name; /* a conductor with n and k from its metal's name and the scene's wavelengths */
    double ior_d; /* of a dielectric with an Abbe number: its index at the d line */
    uint32_t surface_texture; /* of a metallicRoughness: linear, multiplies roughness (green) and
                                 metallic (blue), or MCV_NONE */
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_MATERIALS(MCV_X)
#undef MCV_X
        mcv_medium_params medium; /* of a material that has one (mcv_material_has_medium) */
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
    float *tangents; /* 4 per vertex: direction and the bitangent's sign; NULL if no material needs
                        them */
    uint32_t *indices; /* 3 per triangle */
    double reach[3];   /* the largest absolute coordinates; set by the scene */
} mcv_mesh;

/* A placed mesh. Its triangles have the global indices first_triangle … first_triangle +
 * triangle_count - 1. */
typedef struct mcv_instance {
    char *name; /* of the node */
    uint32_t mesh, material;
    uint32_t emitter; /* index into emitters, or MCV_NONE */
    uint32_t first_triangle;
    bool moves;             /* by the scene's part_motion */
    bool closes_previous;   /* the rim of a body whose other surfaces are the instance before it */
    mcv_transform to_world; /* may mirror: the winding is then reversed, and the normal stays on the
                               front side */
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
 * A body with exact surfaces. The meshes of its instances have the vertices of its box and no
 * triangles. Its pieces have the global indices triangle_count + 3 solid + piece, after those of
 * all triangles.
 */
typedef struct mcv_solid {
    uint32_t side;   /* MCV_SIDE_… (mcvisi/surfaces/solid.h) */
    double radius;   /* of the side [m] */
    double half[2];  /* of a box: half its size along x and y [m] */
    double hole;     /* of an open surface: the radius of its hole [m] */
    mcv_cap caps[2]; /* the first below, the second above; a sphere has none, an open surface only
                        the first */
    bool cemented; /* its first cap is the second cap of the previous solid, with the same frame */
    uint32_t instances[3];  /* of its pieces: first cap, second cap, side */
    mcv_transform to_world; /* rigid */
} mcv_solid;

/*
 * A named node of the file or of one of its assets: its origin in the world, and its axes without
 * scale (they may mirror). Lengths along them are metres of the scene, independent of the scale of
 * node and asset.
 */
typedef struct mcv_placement {
    char *name;
    bool of_asset;
    mcv_transform to_world;
    uint32_t instances[2]; /* those of the node and of the nodes below it: the first, and the one
                              behind the last */
} mcv_placement;

/* A defect on the surface of a node (mcvisi/defects.h). The meshes have it already. */
typedef struct mcv_defect {
    char *name;
    uint32_t type;                       /* MCV_DEFECT_… */
    double size, depth, length, pile_up; /* 0 for those without; depth: of a crack its opening */
    int form;                            /* MCV_SHAPE_… or MCV_PROFILE_… */
    double index;                        /* of a bubble or crack; the step of a stria */
    double roughness;                    /* of a rough patch */
    uint32_t tubes;                      /* of a stria */
    uint32_t host,
        material;          /* inside a body: its material; of an inclusion or stain; or MCV_NONE */
    uint32_t instances[2]; /* of its node, as in mcv_placement */
    double centre[3];      /* on the surface as it was */
    double axes[3][3];     /* u, v and the normal, unit, right-handed */
} mcv_defect;

/* An emitter with a surface belongs to exactly one instance, other emitters to none. */
typedef struct mcv_emitter {
    char *name;
    uint32_t type;      /* MCV_EMITTER_… */
    uint32_t instance;  /* instance whose triangles emit, or MCV_NONE */
    uint32_t texture;   /* multiplies the radiance (glTF emissive texture, parameter `image`), or
                           MCV_NONE */
    double radiance[3]; /* from the parameter or from power [W/(m² sr)]; for some types an
                           irradiance [W/m²] or intensity [W/sr] */
    double area;        /* of the instance in the world [m²]; 0 without one */
    bool by_pixel;      /* each pixel of its image, which is white, is an element of its own
                           (device/pack.h) */
    bool bare_angle;    /* its halfAngle or outerConeAngle was given as a number without a unit */
    mcv_transform
        to_world; /* without an instance: the node's rotation and translation; it emits along -z */
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_EMITTERS(MCV_X)
#undef MCV_X
    } as;
} mcv_emitter;

/* How a node moves (mcvisi/motion.h), in the world; all 0: it stands still. */
typedef struct mcv_node_motion {
    double velocity[3];        /* [m/s] */
    double axis[3], centre[3]; /* unit, [m] */
    double rate;               /* [rad/s] */
} mcv_node_motion;

typedef struct mcv_sensor {
    char *name;
    uint32_t type;          /* MCV_SENSOR_… */
    mcv_transform to_world; /* rotation and translation of the node, scale removed; the sensor looks
                               along the node's -z, +y is up */
    mcv_node_motion motion;
    bool is_head; /* of type laserTriangulation: a thin lens with options for a scan */
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_SENSORS(MCV_X)
#undef MCV_X
        mcv_laser_triangulation_params laser_triangulation; /* a thin lens with is_head */
    } as; /* resolved: the report's parameters are all set */
} mcv_sensor;

/* Bytes that a scene takes while it is loaded, and their limit; 0: none. */
typedef struct mcv_memory {
    uint64_t limit, files, images, geometry;
} mcv_memory;

typedef struct mcv_scene {
    char *path; /* of the file, for messages */
    mcv_memory memory;
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
    mcv_node_motion part_motion; /* of the instances that move */
    mcv_placement *frames;
    uint32_t frame_count;
    mcv_defect *defects;
    uint32_t defect_count;
    double wavelengths[3]; /* of the channels [m]; 0: the defaults */
    uint64_t fingerprint;  /* of all files that were read, in their order */
    char **warnings;       /* sentences for the user */
    uint32_t warning_count;
    size_t ignored_extras; /* objects with extras other than a note */
} mcv_scene;

void mcv_scene_free(mcv_scene *scene);

/* An empty scene to add to. NULL without memory. */
mcv_scene *mcv_scene_new(const char *path);

/* Whether the corners of a box -reach … reach lie near enough for the kernels: within 1e12 m. */
mcv_result mcv_scene_check_extent(const mcv_transform *to_world, const double reach[3],
                                  const mcv_json_path *place, mcv_error *error);

/*
 * Each copies its argument, arrays and names included, and appends it; the new element has the
 * index count - 1. Bad values fail as they would from a file.
 *
 * add_instance sets first_triangle and triangle_count. If the material needs tangents and the mesh
 * has none, it makes them from the texture coordinates, or else along the x axis. add_emitter sets
 * the area, resolves radiance or power, takes the texture from the parameter `image`, and marks its
 * instance. add_sensor resolves the parameters.
 */
mcv_result mcv_scene_add_texture(mcv_scene *scene, const mcv_texture *texture, mcv_error *error);
mcv_result mcv_scene_add_material(mcv_scene *scene, const mcv_material *material, mcv_error *error);
mcv_result mcv_scene_add_mesh(mcv_scene *scene, const mcv_mesh *mesh, mcv_error *error);
mcv_result mcv_scene_add_instance(mcv_scene *scene, const mcv_instance *instance, mcv_error *error);
mcv_result mcv_scene_add_emitter(mcv_scene *scene, const mcv_emitter *emitter, mcv_error *error);

/* insert.c: the same as add_instance, but behind the instance `after` and in all nodes that have
 * this one. Instances and triangles behind it get other numbers. */
mcv_result mcv_scene_insert_instance(mcv_scene *scene, uint32_t after, const mcv_instance *instance,
                                     mcv_error *error);
/* insert.c: numbers the triangles of all instances anew. Fails where they are too many. */
mcv_result mcv_scene_number_triangles(mcv_scene *scene, const mcv_json_path *place,
                                      mcv_error *error);
mcv_result mcv_scene_add_sensor(mcv_scene *scene, const mcv_sensor *sensor, mcv_error *error);

/* `to_world` may scale. A node without a name or with an axis of length 0 is ignored. MCV_FAILED
 * without memory. */
mcv_result mcv_scene_add_frame(mcv_scene *scene, const char *name, bool of_asset,
                               const mcv_transform *to_world, mcv_error *error);

/* Adds a solid and its instances: `body` is the material of the caps, `rim` that of the side (if
 * equal, one instance). */
mcv_result mcv_scene_add_solid(mcv_scene *scene, const mcv_solid *solid, const char *name,
                               uint32_t body, uint32_t rim, mcv_error *error);
/* Adds a defect to the list; the meshes stay as they are. MCV_FAILED without memory. */
mcv_result mcv_scene_add_defect(mcv_scene *scene, const mcv_defect *defect, mcv_error *error);

/* Adds a sentence to the scene's warnings. */
mcv_result mcv_scene_warn(mcv_scene *scene, mcv_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
