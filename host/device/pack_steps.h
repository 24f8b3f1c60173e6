/* SPDX-License-Identifier: Apache-2.0 */
/* The steps of mcv_pack (device/pack.c), one file each; only mcv_pack calls them. */
#ifndef MCVISI_HOST_DEVICE_PACK_STEPS_H
#define MCVISI_HOST_DEVICE_PACK_STEPS_H

#include "device/pack.h"

/* Zeroed memory of at least one element; *failed becomes true without memory. */
void *mcv_pack_allocate(size_t count, size_t size, bool *failed);

/* pack_geometry.c */

mcv_box3d mcv_box3d_empty(void);
void mcv_box3d_extend(mcv_box3d *b, const double p[3]);

/* The scene's centre on a grid of an eighth of its size, a power of two: moving the scene by whole
 * grid steps does not change a bit. */
void mcv_find_centre(const mcv_box3d *boxes, uint32_t count, double centre[3]);

/* Vertices and triangles of one instance. */
void mcv_pack_instance(const mcv_scene *scene, mcv_packed *packed, uint32_t index,
                       uint32_t first_vertex);

/* pack_media.c: gives each dielectric instance a medium. MCV_BAD_INPUT with more than MCV_MAX_MEDIA
 * of them. */
mcv_result mcv_pack_media(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                          mcv_error *error);

/* pack_contacts.c: with the feature CONTACT, where surfaces of bodies come near each other. The
 * bodies have their media. */
mcv_result mcv_pack_contacts(const mcv_scene *scene, mcv_packed *packed, mcv_error *error);

/* pack_materials.c */

mcv_device_material mcv_pack_material(const mcv_material *material);

/* Words of device memory per texel. */
size_t mcv_texel_words(const mcv_texture *texture);
void mcv_pack_textures(const mcv_scene *scene, mcv_packed *packed);

/* MCV_SHADING_… of an instance (kernels/schedule/ranges.h), when all else is packed. */
uint32_t mcv_instance_shading(const mcv_packed *packed, const mcv_device_instance *instance);

/* pack_emitters.c */

/* Entries of an environment's image in the table of shares: its rows, then each row's pixels. */
size_t mcv_environment_entries(const mcv_texture *image);

/* Entries of a laser's table of columns; 0 without one. */
size_t mcv_laser_entries(const mcv_scene *scene, const mcv_emitter *emitter);
mcv_result mcv_pack_emitters(const mcv_scene *scene, mcv_packed *packed, mcv_error *error);

/* light_tree.c: the tree and the emitters' trails, from their other fields. */
mcv_result mcv_pack_light_tree(const mcv_scene *scene, mcv_packed *packed, mcv_error *error);

/* balls.c: packed->balls. They contain the bodies' coordinates as rounded on the device. */
void mcv_find_balls(const mcv_scene *scene, mcv_packed *packed);

#endif
