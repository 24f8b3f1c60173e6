/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule, for CPUs: one work-item per work-group takes a slice of MCV_SLICE paths
 * through all stages. Their state is private, so that it stays in the core's cache and no other
 * memory sees it. The paths under way lie side by side in the slots 0 … alive - 1: what can be
 * worked out without branches runs as a plain loop over them, which the compiler vectorises.
 */
#define MCV_TILE 1
#define MCV_ROWS_SPACE __private

/*
 * Before a loop whose turns do not read what others write. PoCL's front end cannot vectorise it
 * before its back end has inlined fma. Left to itself the compiler takes four turns at once where a
 * loop divides integers. It stands where a statement may.
 */
#if defined(__clang__) && defined(__AVX512F__)
#pragma clang diagnostic ignored "-Wpass-failed"
/* Clang prefers registers of eight lanes but in functions that take a vector of sixteen, and in
 * whatever these are inlined into. */
static inline __attribute__((always_inline)) void mcv_prefer_sixteen_lanes(float16 lanes) {
    (void)lanes;
}
#define MCV_VECTORIZE \
    mcv_prefer_sixteen_lanes((float16)(0.0f)); \
    _Pragma("clang loop vectorize(assume_safety) vectorize_width(16)")
/* The same where a turn takes long: the last, too, run together, as masks leave out what is too
 * much. */
#define MCV_VECTORIZE_MASKED \
    mcv_prefer_sixteen_lanes((float16)(0.0f)); \
    _Pragma("clang loop vectorize(assume_safety) vectorize_width(16) vectorize_predicate(enable)")
#elif defined(__clang__)
#pragma clang diagnostic ignored "-Wpass-failed"
#define MCV_VECTORIZE _Pragma("clang loop vectorize(assume_safety) vectorize_width(8)")
#define MCV_VECTORIZE_MASKED MCV_VECTORIZE
#else
#define MCV_VECTORIZE
#define MCV_VECTORIZE_MASKED
#endif

#include "world.h"
#include "schedule/compact.h"
#include "traverse/policy.h"
#if MCV_WITH_AIM
#include "stage/guide_pupil.h"
#endif
#include "stage/generate_rays.h"
#include "stage/intersect_closest.h"
#if MCV_WITH_NEXT_EVENT
#include "stage/sample_emitters.h"
#include "stage/intersect_shadow.h"
#endif
#include "stage/shade_hit.h"
#include "schedule/ranges.h"
#if MCV_WITH_NEXT_EVENT
#include "schedule/sample_emitter_rows.h"
#endif
#include "schedule/split_paths.h"
#include "schedule/small_scene_cache.h"
#include "stage/accumulate_film.h"
#if MCV_WITH_LIGHT_TRACING
#include "stage/trace_light_path.h"
#endif
#include "schedule/clock.h"
#include "schedule/terminate_paths.h"

#define MCV_ROWS(slot, field) \
    { (slot).base + MCV_PATH_##field *MCV_ROW, 1u, MCV_ROW }

#if MCV_WITH_SURFACES
/* Rays side by side: rows of MCV_ROW words for each component. The directions are unit. */
typedef struct mcv_ray_rows {
    const uint *origin, *direction, *origin_surface;
} mcv_ray_rows;

MCV_LOOP_FUNCTION mcv_vec3 mcv_one_of(const uint *rows, uint i) {
    return mcv_vec(as_float(rows[i]), as_float(rows[MCV_ROW + i]), as_float(rows[2 * MCV_ROW + i]));
}

/* Rays with one solid, of a shape that is known to the compiler. */
MCV_LOOP_FUNCTION void mcv_intersect_solid_row(mcv_world world, mcv_ray_rows rays, uint number,
                                               uint shape, uint count, uint *t, uint *pieces) {
    __global const mcv_device_solid *solid = world.solids + number;
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        const mcv_solid_ray ray =
            mcv_make_solid_ray(world, number, mcv_one_of(rays.origin, i),
                               mcv_one_of(rays.direction, i), rays.origin_surface[i]);
        const mcv_piece_hit met = mcv_intersect_shape(solid, shape, ray);
        t[i] = as_uint(met.t);
        pieces[i] = met.piece;
    }
}

/* Which rays may meet a solid; returns how many. */
static __attribute__((noinline)) uint mcv_find_approaching(mcv_world world, mcv_ray_rows rays,
                                                           uint count, uint number, mcv_hits hits,
                                                           uint *reaches) {
    __global const mcv_device_solid *solid = world.solids + number;
    uint near = 0;
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const int meets = mcv_reaches_solid(solid, mcv_one_of(rays.origin, i),
                                            mcv_one_of(rays.direction, i), as_float(hits.t[i]));
        reaches[i] = (uint)(meets & (i < count));
        near += reaches[i];
    }
    return near;
}

/* mcv_take_exact_hit of the rays that may meet a solid. */
static __attribute__((noinline)) void mcv_take_exact_hits(mcv_world world, const uint *t,
                                                          const uint *pieces, uint number,
                                                          uint count, const uint *reaches,
                                                          mcv_hits hits) {
    uint tied[MCV_ROW], ties = 0;
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const float before = as_float(hits.t[i]), here = as_float(t[i]);
        const uint triangle = hits.triangle[i];
        const int closer = (reaches[i] != 0u) & (here < before);
        tied[i] = (reaches[i] != 0u) & (here == before) & (triangle >= MCV_EXACT) &
                  (triangle != MCV_NONE);
        ties += tied[i];
        hits.t[i] = as_uint(closer ? here : before);
        hits.u[i] = closer ? 0u : hits.u[i];
        hits.v[i] = closer ? 0u : hits.v[i];
        hits.triangle[i] = closer ? MCV_EXACT | 4u * number | pieces[i] : triangle;
    }
    for (uint i = 0; ties > 0 && i < count; ++i) {
        if (!tied[i]) continue;
        mcv_hit hit = mcv_hit_of(hits, i);
        mcv_take_exact_hit(world, as_float(t[i]), number, pieces[i], &hit);
        mcv_put_hit(hits, i, hit);
    }
}

/* What many rays meet of the exact surfaces, if that is closer than the given hits (or misses, with
 * their t_max). */
static __attribute__((noinline)) void mcv_intersect_solid_rows(mcv_world world, mcv_ray_rows rays,
                                                               uint count, mcv_hits hits) {
    uint reaches[MCV_ROW], t[MCV_ROW], pieces[MCV_ROW], rows[7 * MCV_ROW], packed[2 * MCV_ROW];
    for (uint number = 0; number < world.frame->solid_count; ++number) {
        __global const mcv_device_solid *solid = world.solids + number;
        const uint shape = mcv_shape(solid),
                   near = mcv_find_approaching(world, rays, count, number, hits, reaches);
        if (near == 0u) continue;
        /* Where they are fewer than half they are set side by side. */
        const int few = shape == MCV_SHAPE_OTHER || 2u * near < count;
        mcv_ray_rows own = rays;
        uint *own_t = t;
        uint *own_pieces = pieces;
        uint own_count = count;
        if (few) {
            for (uint axis = 0; axis < 3; ++axis) {
                mcv_compact_row(reaches, rays.origin + axis * MCV_ROW, count,
                                rows + axis * MCV_ROW);
                mcv_compact_row(reaches, rays.direction + axis * MCV_ROW, count,
                                rows + (3 + axis) * MCV_ROW);
            }
            mcv_compact_row(reaches, rays.origin_surface, count, rows + 6 * MCV_ROW);
            own = (mcv_ray_rows){rows, rows + 3 * MCV_ROW, rows + 6 * MCV_ROW};
            own_t = packed;
            own_pieces = packed + MCV_ROW;
            own_count = near;
        }
        switch (shape) {
        case MCV_SHAPE_OTHER:
            for (uint i = 0; i < own_count; ++i) {
                const mcv_solid_ray ray =
                    mcv_make_solid_ray(world, number, mcv_one_of(own.origin, i),
                                       mcv_one_of(own.direction, i), own.origin_surface[i]);
                const mcv_piece_hit met = mcv_intersect_other(solid, &ray);
                own_t[i] = as_uint(met.t);
                own_pieces[i] = met.piece;
            }
            break;
        case MCV_SHAPE_DISC:
            mcv_intersect_solid_row(world, own, number, MCV_SHAPE_DISC, own_count, own_t,
                                    own_pieces);
            break;
        case MCV_SHAPE_BALL:
            mcv_intersect_solid_row(world, own, number, MCV_SHAPE_BALL, own_count, own_t,
                                    own_pieces);
            break;
        case MCV_SHAPE_BOX:
            mcv_intersect_solid_row(world, own, number, MCV_SHAPE_BOX, own_count, own_t,
                                    own_pieces);
            break;
        default:
            mcv_intersect_solid_row(world, own, number, MCV_SHAPE_CONICS, own_count, own_t,
                                    own_pieces);
        }
        if (few) {
            mcv_expand_row(reaches, packed, count, t);
            mcv_expand_row(reaches, packed + MCV_ROW, count, pieces);
        }
        mcv_take_exact_hits(world, t, pieces, number, count, reaches, hits);
    }
}

MCV_FUNCTION float mcv_least_lane(float8 lanes) {
    const float4 four = min(lanes.lo, lanes.hi);
    const float2 two = min(four.lo, four.hi);
    return min(two.x, two.y);
}

MCV_FUNCTION float mcv_most_lane(float8 lanes) {
    const float4 four = max(lanes.lo, lanes.hi);
    const float2 two = max(four.lo, four.hi);
    return max(two.x, two.y);
}

/* The rays that meet the box of all triangles before they end; returns how many. Margins as in
 * kernels/traverse/bvh8.h. */
static __attribute__((noinline)) uint mcv_list_near_triangles(mcv_world world, uint *paths,
                                                              uint count, uint *chosen) {
    uint meets[MCV_ROW];
    float low[3], high[3];
    mcv_slot slot;
    const float extent = world.nodes->extent;
    slot.base = paths;
    for (uint axis = 0; axis < 3; ++axis) {
        low[axis] = mcv_least_lane(*(__global const float8 *)world.nodes->bounds[axis][0]);
        high[axis] = mcv_most_lane(*(__global const float8 *)world.nodes->bounds[axis][1]);
    }
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        slot.index = i;
        const mcv_vec3 o = MCV_LOAD_3(slot, origin), d = MCV_LOAD_3(slot, direction);
        meets[i] = (uint)mcv_hits_box(low, high, extent, o, d, MCV_LOAD(slot, hit, 0));
    }
    return mcv_compact_indices(meets, count, chosen);
}
#endif

#if MCV_WITH_ABSORPTION
static __attribute__((noinline)) void mcv_absorb_together(mcv_world world, uint *paths,
                                                          uint count) {
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        mcv_absorb(world, slot);
    }
}
#endif

/* The stages that intersect, over the paths of a slice. */
static void mcv_intersect_paths(mcv_world world, mcv_slot slot, uint count) {
    const mcv_rows origins = MCV_ROWS(slot, origin), directions = MCV_ROWS(slot, direction);
    const mcv_hits hits = mcv_hits_in(slot.base + MCV_PATH_hit * MCV_ROW, MCV_ROW);
    uint chosen[MCV_ROW];
    uint listed = count;
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        mcv_put_hit(hits, i, mcv_miss(INFINITY));
        chosen[i] = i;
    }
#if MCV_WITH_SURFACES
    const mcv_ray_rows rays = {slot.base + MCV_PATH_origin * MCV_ROW,
                               slot.base + MCV_PATH_direction * MCV_ROW,
                               slot.base + MCV_PATH_origin_surface * MCV_ROW};
    mcv_intersect_solid_rows(world, rays, count, hits);
    /* The triangles of two leaves take no longer than the box that holds them. */
    if (!mcv_is_flat(world.nodes) || world.nodes->child[2] != MCV_NONE)
        listed = mcv_list_near_triangles(world, slot.base, count, chosen);
#endif
    MCV_TRACE_CLOSEST(world.nodes, world.leaves, origins, directions, chosen, listed, hits);
#if MCV_WITH_ABSORPTION
    mcv_absorb_together(world, slot.base, count);
#endif
}

#if MCV_WITH_NEXT_EVENT
#if MCV_WITH_SURFACES
/*
 * What the shadow rays of the paths first … last - 1 meet, of triangles (the given hits) and exact
 * surfaces (mcv_shadow_past_solids). A ray that ends at -INFINITY is none.
 */
static __attribute__((noinline)) void mcv_shadows_past_solids(mcv_world world, const uint *paths,
                                                              uint first, uint last, int any,
                                                              mcv_hits hits) {
    uint rows[8 * MCV_ROW];
    float lengths[MCV_ROW];
    const uint count = last - first;
    const mcv_hits exact = mcv_hits_in(rows + 4 * MCV_ROW, MCV_ROW);
    const mcv_ray_rows fate = {paths + MCV_PATH_shadow_origin * MCV_ROW + first,
                               paths + MCV_PATH_shadow_direction * MCV_ROW + first,
                               paths + MCV_PATH_shadow_origin_surface * MCV_ROW + first};
    const mcv_ray_rows rays = {fate.origin, rows, rows + 3 * MCV_ROW};
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const mcv_vec3 way = mcv_one_of(fate.direction, i);
        const float length = mcv_sqrt(mcv_dot(way, way));
        const mcv_vec3 unit = mcv_scale(way, 1.0f / length);
        const float end = as_float(hits.t[first + i]);
        const uint met = hits.triangle[first + i];
        rows[i] = as_uint(unit.x);
        rows[MCV_ROW + i] = as_uint(unit.y);
        rows[2 * MCV_ROW + i] = as_uint(unit.z);
        rows[3 * MCV_ROW + i] = end > -INFINITY ? fate.origin_surface[i] : MCV_NONE;
        lengths[i] = length;
        exact.t[i] = as_uint((any & (met != MCV_NONE)) ? -INFINITY : end * length);
        exact.u[i] = hits.u[first + i];
        exact.v[i] = hits.v[first + i];
        exact.triangle[i] = met;
    }
    mcv_intersect_solid_rows(world, rays, count, exact);
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const int closer = exact.triangle[i] != hits.triangle[first + i];
        hits.t[first + i] = closer ? as_uint(as_float(exact.t[i]) / lengths[i]) : hits.t[first + i];
        hits.u[first + i] = closer ? exact.u[i] : hits.u[first + i];
        hits.v[first + i] = closer ? exact.v[i] : hits.v[first + i];
        hits.triangle[first + i] = exact.triangle[i];
    }
}
#endif

/* No hits of the paths first … last - 1, and no rays. */
static __attribute__((noinline)) void mcv_begin_shadows(mcv_hits hits, uint first, uint last) {
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(last - first); ++i)
        mcv_put_hit(hits, first + i, mcv_miss(-INFINITY));
}

/* The light of shadow rays that nothing blocks; where any hit does they have not met one, else they
 * have met their target. */
static __attribute__((noinline)) void
mcv_add_shadow_lights(mcv_world world, uint *paths, uint first, uint last, int any, mcv_hits hits) {
    mcv_slot slot;
    slot.base = paths;
#if !((MCV_WITH_PARALLEL || MCV_WITH_BEAM) && MCV_WITH_TEXTURE)
    MCV_VECTORIZE
#endif
    for (uint i = 0; i < mcv_fill_lanes(last - first); ++i) {
        slot.index = first + i;
        const mcv_hit hit = mcv_hit_of(hits, slot.index);
        mcv_add_shadow_light(world, slot, hit,
                             (hit.t > -INFINITY) & (!any | (hit.triangle == MCV_NONE)));
    }
}

/* Of the paths in these slots, in ascending order. */
static void mcv_intersect_shadows(mcv_world world, mcv_slot slot, const uint *paths, uint count) {
    const mcv_rows origins = MCV_ROWS(slot, shadow_origin),
                   directions = MCV_ROWS(slot, shadow_direction);
    uint rows[4 * MCV_ROW];
    const mcv_hits hits = mcv_hits_in(rows, MCV_ROW);
    for (int any = !MCV_WITH_TARGETS; any < 2; ++any) {
        const uint *chosen = paths;
        uint chosen_count = count;
#if MCV_WITH_TARGETS
        uint flags[MCV_SLOTS], listed[MCV_SLOTS];
        for (uint i = 0; i < count; ++i) {
            slot.index = paths[i];
            flags[i] = mcv_shadow_is_any(slot) == any;
        }
        chosen = listed;
        chosen_count = mcv_compact_row(flags, paths, count, listed);
#endif
        if (chosen_count == 0u) continue;
        const uint first = chosen[0], last = chosen[chosen_count - 1u] + 1u;
        mcv_begin_shadows(hits, first, last);
        for (uint i = 0; i < chosen_count; ++i) {
            slot.index = chosen[i];
            hits.t[slot.index] = as_uint(mcv_shadow_end(slot));
        }
        if (any)
            MCV_TRACE_ANY(world.nodes, world.leaves, origins, directions, chosen, chosen_count,
                          hits);
        else
            MCV_TRACE_CLOSEST(world.nodes, world.leaves, origins, directions, chosen, chosen_count,
                              hits);
#if MCV_WITH_SURFACES
        mcv_shadows_past_solids(world, slot.base, first, last, any, hits);
#endif
        for (uint i = 0; i < chosen_count && !any; ++i) {
            slot.index = chosen[i];
            if (!mcv_hits_target(world, slot, mcv_hit_of(hits, slot.index)))
                hits.t[slot.index] = as_uint(-INFINITY);
        }
        mcv_add_shadow_lights(world, slot.base, first, last, any, hits);
    }
}
#endif

#if MCV_WITH_AIM
/* One work-item per slice of pixels. */
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
guide_pupil(MCV_WORLD_PARAMETERS __global mcv_device_pupil_guide *out) {
    MCV_MAKE_WORLD(world)
    const uint first = (uint)get_group_id(0) * MCV_SLICE;
    const uint last = min(first + MCV_SLICE, world.frame->width * world.frame->height);
    for (uint pixel = first; pixel < last; ++pixel) mcv_guide_pupil(world, pixel, out + pixel);
}
#endif

/* The paths in the slots chosen[0 … count - 1], in ascending order, go on in the slots 0 … count -
 * 1: the last ones where others ended. */
static __attribute__((noinline)) void mcv_move_paths(uint *paths, const uint *chosen, uint count) {
    uint from[MCV_SLOTS];
    uint to[MCV_SLOTS];
    uint moves = 0;
    for (uint slot = 0, next = 0; slot < count; ++slot) {
        if (chosen[next] == slot) {
            ++next;
        } else {
            to[moves] = slot;
            from[moves] = chosen[count - 1u - moves];
            ++moves;
        }
    }
    for (uint word = 0; word < MCV_PATH_hit; ++word) {
        uint *row = paths + word * MCV_ROW;
        for (uint i = 0; i < moves; ++i) row[to[i]] = row[from[i]];
    }
}

/* Draws one of the pairs of random numbers of the surfaces that the paths have met. */
static __attribute__((noinline)) void mcv_draw_pairs(uint *paths, uint first, uint last, uint depth,
                                                     uint pair) {
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE
    for (uint i = first; i < first + mcv_fill_lanes(last - first); ++i) {
        slot.index = i;
        const mcv_pair drawn = mcv_sample_pair(MCV_WORD(slot, stream, 0), MCV_WORD(slot, sample, 0),
                                               MCV_SURFACE_PAIR(depth, pair));
        MCV_STORE(slot, drawn, 2u * pair, drawn.x);
        MCV_STORE(slot, drawn, 2u * pair + 1u, drawn.y);
    }
}

#if MCV_WITH_DIFFUSE
/* Where the paths go on from the surfaces that they have met if these are diffuse. */
static __attribute__((noinline)) void mcv_sample_diffuse_directions(uint *paths, uint first,
                                                                    uint last) {
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE
    for (uint i = first; i < first + mcv_fill_lanes(last - first); ++i) {
        slot.index = i;
        const float xi = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER);
        const float eta = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER + 1);
        float density;
        const mcv_vec3 bounce = mcv_diffuse_sample(MCV_LOAD_3(slot, normal), xi, eta, &density);
        MCV_STORE_3(slot, bounce, bounce);
        MCV_STORE(slot, bounce, 3, density);
    }
}
#endif

#if MCV_LEAVES_TOGETHER
/* The origins of the rays that go on, in the directions that they have got. */
static __attribute__((noinline)) void mcv_offset_origins(uint *paths, uint count) {
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const mcv_vec3 origin =
            mcv_offset_origin(MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, error),
                              MCV_LOAD_3(slot, face), MCV_LOAD_3(slot, direction));
        MCV_STORE_3(slot, origin, origin);
    }
}
#endif

MCV_LOOP_FUNCTION void mcv_find_triangles(mcv_world world, mcv_slot slot, uint first, uint last) {
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        mcv_find_triangle(world, slot);
    }
}

#if MCV_WITH_SURFACES
static __attribute__((noinline)) void mcv_find_exacts(mcv_world world, mcv_slot slot, uint first,
                                                      uint last) {
    const uint *met = slot.base + (MCV_PATH_hit + 3) * MCV_ROW;
    if (first == last) return;
    const uint piece = met[first];
    uint others = 0, quadrics = 0;
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) others += met[i] != piece;
    if (others == 0u)
        quadrics = mcv_is_quadric(world.solids + ((piece & ~MCV_EXACT) >> 2), piece & 3u)
                       ? last - first
                       : 0u;
    else
        for (uint i = first; i < last; ++i)
            quadrics += mcv_is_quadric(world.solids + ((met[i] & ~MCV_EXACT) >> 2), met[i] & 3u);
    if (quadrics > 0 && others == 0u) {
        MCV_VECTORIZE_MASKED
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            mcv_find_exact(world, slot, piece, 1);
        }
    } else if (quadrics > 0) {
        MCV_VECTORIZE_MASKED
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            mcv_find_exact(world, slot, met[i], 1);
        }
    }
    if (quadrics == last - first) return;
    for (slot.index = first; slot.index < last; ++slot.index)
        if (!mcv_is_quadric(world.solids + ((met[slot.index] & ~MCV_EXACT) >> 2),
                            met[slot.index] & 3u))
            mcv_find_exact(world, slot, met[slot.index], 0);
}
#endif

/* Works out the surfaces that the paths have met, which lie in the order of mcv_sort_paths. */
static __attribute__((noinline)) void mcv_find_surfaces(mcv_world world, uint *paths,
                                                        const uint *class_end) {
    mcv_slot slot;
    slot.base = paths;
#if MCV_CACHED && !MCV_WITH_NORMALS
    if (world.frame->triangle_count - 1u < MCV_CACHED &&
        class_end[MCV_CLASS_EXACT] >= 2 * MCV_CACHED) {
        mcv_facet_table table;
        mcv_fill_facets(world, &table);
        mcv_find_cached_triangles(paths, &table, 0, class_end[MCV_CLASS_SMOOTH_TRIANGLE]);
        mcv_find_cached_triangles(paths, &table, class_end[MCV_CLASS_GLOSS_EXACT],
                                  class_end[MCV_CLASS_TRIANGLE]);
    } else
#endif
    {
        mcv_find_triangles(world, slot, 0, class_end[MCV_CLASS_SMOOTH_TRIANGLE]);
        mcv_find_triangles(world, slot, class_end[MCV_CLASS_GLOSS_EXACT],
                           class_end[MCV_CLASS_TRIANGLE]);
    }
#if MCV_WITH_SURFACES
    mcv_find_exacts(world, slot, class_end[MCV_CLASS_SMOOTH_TRIANGLE],
                    class_end[MCV_CLASS_SMOOTH_EXACT]);
    mcv_find_exacts(world, slot, class_end[MCV_CLASS_SMOOTH_EXACT],
                    class_end[MCV_CLASS_GLOSS_EXACT]);
    mcv_find_exacts(world, slot, class_end[MCV_CLASS_TRIANGLE], class_end[MCV_CLASS_EXACT]);
#endif
}

#if MCV_WITH_NEXT_EVENT
/* Lists the paths that have a shadow ray to follow; returns how many. */
static __attribute__((noinline)) uint mcv_sample_emitters(mcv_world world, mcv_slot slot,
                                                          const uint *class_end, uint gloss,
                                                          uint depth, uint *shadows) {
    const uint alive = class_end[MCV_CLASS_EXACT];
    uint shadow_count = 0, first = class_end[MCV_CLASS_SMOOTH_EXACT];
    (void)gloss;
#if MCV_WITH_PLAIN
    mcv_select_plain_emitters(world, slot, class_end, gloss);
    mcv_sample_emitter_rows(world, slot, first, class_end[MCV_CLASS_DIFFUSE_TRIANGLE]);
    shadow_count = mcv_list_plain_shadows(world, slot, class_end, gloss, shadows);
    first = class_end[MCV_CLASS_DIFFUSE_TRIANGLE];
#endif
    for (slot.index = first; slot.index < alive; ++slot.index)
        MCV_WORD(slot, emitter, 0) = mcv_choose_emitter(world, slot, depth);
    mcv_sample_emitter_rows(world, slot, first, alive);
    for (slot.index = first; slot.index < alive; ++slot.index) {
        if (MCV_WORD(slot, emitter, 0) == MCV_NONE) continue;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        if (mcv_make_shadow_ray(world, slot, &interaction, mcv_any_shading(), mcv_shadow_in(slot)))
            shadows[shadow_count++] = slot.index;
    }
    return shadow_count;
}
#endif

#if MCV_WITH_LIGHT_TRACING
#include "schedule/light_paths.h"

/* One work-item per 2^log2_thinning slices of paths: on average as many light paths as a slice has.
 */
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
trace_emitter_paths(MCV_WORLD_PARAMETERS __global uint *splats, __global uint *counters) {
    MCV_MAKE_WORLD(world)
    const uint slice = get_group_id(0), count = world.frame->path_count,
               span = (uint)MCV_SLICE << world.frame->log2_thinning;
    uint counts[MCV_COUNTER_COUNT] = {0};
    mcv_trace_light_slices(world, slice * span, min(slice * span + min(span, count), count), splats,
                           counts);
    for (uint i = 0; i < MCV_COUNTER_COUNT; ++i)
        counters[slice * MCV_COUNTER_COUNT + i] += counts[i];
}
#endif

/* Begins the paths first … first + count - 1 of the launch; returns how many have. */
static __attribute__((noinline)) uint mcv_begin_paths(mcv_world world, mcv_slot slot, uint first,
                                                      uint count) {
    uint columns[MCV_SLOTS];
    uint rows[MCV_SLOTS];
    uint begins[MCV_SLOTS], begun[MCV_SLOTS];
    const uint samples = 1u << world.frame->log2_samples;
    for (uint from = 0, to; from < count; from = to) {
        const mcv_identity id = mcv_identify(world, first + from);
        to = min(count, from + samples - ((first + from) & (samples - 1u)));
        MCV_VECTORIZE
        for (uint i = from; i < to; ++i) {
            slot.index = i;
            columns[i] = id.column;
            rows[i] = id.row;
            MCV_WORD(slot, stream, 0) = id.stream;
            MCV_WORD(slot, sample, 0) = id.sample + (i - from);
        }
    }
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        mcv_identity begun_by;
        begun_by.column = columns[i];
        begun_by.row = rows[i];
        begun_by.stream = MCV_WORD(slot, stream, 0);
        begun_by.sample = MCV_WORD(slot, sample, 0);
        mcv_generate_ray(world, slot, begun_by);
        MCV_WORD(slot, value, 0) = i;
        begins[i] = MCV_LOAD(slot, weight, 0) > 0.0f;
    }
    const uint alive = mcv_compact_indices(begins, count, begun);
    if (alive < count) mcv_move_paths(slot.base, begun, alive);
    return alive;
}

/* Not inlined: PoCL makes three functions of a kernel, of which it calls one. */
static __attribute__((noinline)) void mcv_render_slice(mcv_world world, uint slice,
                                                       __global float *sums,
                                                       __global uint *counters,
                                                       __global uint *clocks) {
    const uint first = slice * MCV_SLICE;
    const uint count = min((uint)MCV_SLICE, world.frame->path_count - first);
    uint paths[MCV_PATH_WORDS * MCV_ROW];
    float values[MCV_CHANNELS * MCV_SLOTS];
    uint chosen[MCV_SLOTS];
    uint classes[MCV_ROW], class_end[MCV_CLASS_COUNT], fate[MCV_ROW], flags[MCV_ROW],
        ended[MCV_SLOTS], gloss;
    uint counts[MCV_COUNTER_COUNT] = {0};
    uint branches = 1; /* numbers of branches that there may be by now */
    mcv_slot slot;
    slot.base = paths;
#if MCV_WITH_GLOSS
    mcv_gloss_interaction glosses[MCV_SLOTS];
    slot.glosses = glosses;
#endif
    MCV_CLOCK_BEGIN

    mcv_clear_values(values, 0);
    uint alive = mcv_begin_paths(world, slot, first, count);
    counts[MCV_COUNTER_paths] = alive;
    MCV_CLOCK_STAGE(generate_rays)
    for (uint depth = 0; depth < world.frame->depth && alive > 0; ++depth) {
        counts[MCV_COUNTER_rays] += alive;
        mcv_intersect_paths(world, slot, alive);
        MCV_CLOCK_STAGE(intersect_closest)
        mcv_classify_hits(world, paths, alive, classes, &gloss);
        counts[MCV_COUNTER_nonfinite] +=
            mcv_terminate_early(world, paths, classes, alive, depth, values);
        mcv_sort_paths(paths, classes, alive, class_end);
        alive = class_end[MCV_CLASS_EXACT];
        mcv_find_surfaces(world, paths, class_end);
#if MCV_WITH_PLAIN
        mcv_find_reflectances(world, paths, class_end[MCV_CLASS_SMOOTH_EXACT],
                              class_end[MCV_CLASS_DIFFUSE_EXACT]);
        mcv_find_reflectances(world, paths, class_end[MCV_CLASS_GLOSS_TRIANGLE],
                              class_end[MCV_CLASS_DIFFUSE_TRIANGLE]);
#endif
        if (mcv_needs_choice(world.frame, depth))
            mcv_draw_pairs(paths, 0, alive, depth, MCV_PAIR_CHOICE);
#if MCV_WITH_NEXT_EVENT
        /* An emitter is a surface too: the last surface a path may meet does not look for one. */
        if (depth + 1 < world.frame->depth) {
            mcv_draw_pairs(paths, class_end[MCV_CLASS_SMOOTH_EXACT], alive, depth,
                           MCV_PAIR_EMITTER);
            const uint shadow_count =
                mcv_sample_emitters(world, slot, class_end, gloss, depth, chosen);
            MCV_CLOCK_STAGE(sample_emitters)
            mcv_intersect_shadows(world, slot, chosen, shadow_count);
            MCV_CLOCK_STAGE(intersect_shadow)
            counts[MCV_COUNTER_shadow_rays] += shadow_count;
        }
#endif
        mcv_draw_pairs(paths, 0, alive, depth, MCV_PAIR_SCATTER);
#if MCV_WITH_DIFFUSE
        mcv_sample_diffuse_directions(paths, class_end[MCV_CLASS_SMOOTH_EXACT], alive);
#endif
        mcv_slot beside = slot;
        beside.index = alive;
        for (uint i = 0; i < alive; ++i) fate[i] = MCV_UNSHADED;
#if MCV_WITH_PLAIN || MCV_WITH_SMOOTH
        mcv_shade_ranges(world, paths, class_end, gloss, depth, fate,
                         &counts[MCV_COUNTER_unmatched]);
#endif
#if MCV_WITH_SMOOTH && MCV_WITH_SPLIT
        beside.index =
            mcv_split_paths(world, paths, fate, class_end[MCV_CLASS_GLOSS_TRIANGLE], alive);
#endif
        MCV_VECTORIZE
        for (uint i = 0; i < alive; ++i) flags[i] = fate[i] == MCV_UNSHADED;
        const uint unshaded = mcv_compact_indices(flags, alive, chosen);
        for (uint i = 0; i < unshaded; ++i) {
            slot.index = chosen[i];
            fate[slot.index] =
                mcv_shade_surface(world, slot, beside, depth, &counts[MCV_COUNTER_unmatched]);
            beside.index += (fate[slot.index] & MCV_SPLITS) != 0u;
        }
        MCV_VECTORIZE
        for (uint i = 0; i < mcv_fill_lanes(alive); ++i) flags[i] = fate[i] & MCV_CONTINUES;
        uint next = mcv_compact_indices(flags, alive, chosen);
        if (next < alive) {
            MCV_VECTORIZE
            for (uint i = 0; i < mcv_fill_lanes(alive); ++i) flags[i] = !flags[i];
            counts[MCV_COUNTER_nonfinite] += mcv_terminate_paths(
                world, paths, ended, mcv_compact_indices(flags, alive, ended), values);
        }
        /* A path splits at most once at each surface. */
        while (beside.index > alive && branches < min(depth + 2u, (uint)MCV_BRANCHES))
            mcv_clear_values(values, branches++);
#if MCV_LEAVES_TOGETHER
        mcv_offset_origins(paths, alive);
#endif
        for (; alive < beside.index; ++alive) chosen[next++] = alive;
        if (next < alive) mcv_move_paths(paths, chosen, next);
        alive = next;
        MCV_CLOCK_STAGE(shade_surfaces)
    }

    for (slot.index = 0; slot.index < alive; ++slot.index) {
        counts[MCV_COUNTER_lost] += mcv_lost_energy(slot);
        ended[slot.index] = slot.index;
    }
    counts[MCV_COUNTER_nonfinite] += mcv_terminate_paths(world, paths, ended, alive, values);
    counts[MCV_COUNTER_depth_cut] = alive;

    const uint block = min((uint)MCV_BLOCK, 1u << world.frame->log2_samples);
    for (uint channel = 0; channel < MCV_CHANNELS; ++channel)
        mcv_accumulate_blocks(values + channel * MCV_SLOTS, branches, count, block,
                              sums + ((size_t)(first / block) * MCV_CHANNELS + channel) * 2u);
    MCV_CLOCK_STAGE(accumulate_film)
    MCV_CLOCK_END(clocks + slice * MCV_CLOCK_COUNT)
    (void)clocks;
    for (uint i = 0; i < MCV_COUNTER_COUNT; ++i)
        counters[slice * MCV_COUNTER_COUNT + i] = counts[i];
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
render_tile(MCV_WORLD_PARAMETERS __global float *sums, __global uint *counters) {
    MCV_MAKE_WORLD(world)
    mcv_render_slice(world, get_group_id(0), sums, counters,
                     counters + get_num_groups(0) * MCV_COUNTER_COUNT);
}
