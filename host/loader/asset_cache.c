/* SPDX-License-Identifier: Apache-2.0 */
/* Parsed assets, kept for the next load of the same scene. */
#include "loader/loader.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

struct mcv_asset_cache {
    mcv_cached_asset *assets;
    size_t count, read;
};

/* --- stamps --- */

static bool read_stamp(const char *path, mcv_stamp *stamp) {
    struct stat s;
    if (stat(path, &s) != 0) return false;
    *stamp = (mcv_stamp){.device = s.st_dev,
                         .inode = s.st_ino,
                         .size = (uint64_t)s.st_size,
                         .modified = s.st_mtim,
                         .changed = s.st_ctim};
    return true;
}

static bool same_time(const struct timespec *a, const struct timespec *b) {
    return a->tv_sec == b->tv_sec && a->tv_nsec == b->tv_nsec;
}

static bool is_unchanged(const mcv_stamp *stamp) {
    mcv_stamp now;
    return read_stamp(stamp->path, &now) && now.device == stamp->device &&
           now.inode == stamp->inode && now.size == stamp->size &&
           same_time(&now.modified, &stamp->modified) && same_time(&now.changed, &stamp->changed);
}

mcv_result mcv_stamp_add(mcv_loader *loader, const char *path, const mcv_json_path *place,
                         mcv_error *error) {
    mcv_stamp stamp;
    if (!read_stamp(path, &stamp))
        return mcv_fail_at(place, error, "\"%s\" cannot be opened: %s", path, strerror(errno));
    stamp.path = strdup(path);
    mcv_stamp *stamps = realloc(loader->stamps, (loader->stamp_count + 1) * sizeof *stamps);
    if (stamps) loader->stamps = stamps;
    if (!stamp.path || !stamps) {
        free(stamp.path);
        return mcv_fail_memory(place, error);
    }
    loader->stamps[loader->stamp_count++] = stamp;
    return MCV_OK;
}

void mcv_stamps_free(mcv_stamp *stamps, size_t count) {
    for (size_t i = 0; i < count; ++i) free(stamps[i].path);
    free(stamps);
}

/* --- assets --- */

mcv_asset_cache *mcv_asset_cache_new(void) { return calloc(1, sizeof(mcv_asset_cache)); }

static void forget(mcv_cached_asset *a) {
    mcv_stamps_free(a->stamps, a->stamp_count);
    json_decref(a->root);
    mcv_gltf_free(a->gltf);
    mcv_scene_free(a->solid);
}

void mcv_asset_cache_free(mcv_asset_cache *cache) {
    if (!cache) return;
    for (size_t i = 0; i < cache->count; ++i) forget(cache->assets + i);
    free(cache->assets);
    free(cache);
}

size_t mcv_asset_cache_reads(const mcv_asset_cache *cache) { return cache->read; }

void mcv_asset_cache_drop_changed(mcv_asset_cache *cache) {
    size_t left = 0;
    for (size_t i = 0; i < cache->count; ++i) {
        const mcv_cached_asset *a = cache->assets + i;
        bool unchanged = true;
        for (size_t k = 0; k < a->stamp_count; ++k)
            unchanged = unchanged && is_unchanged(a->stamps + k);
        if (unchanged)
            cache->assets[left++] = *a;
        else
            forget(cache->assets + i);
    }
    cache->count = left;
}

const mcv_cached_asset *mcv_asset_cache_find(const mcv_asset_cache *cache, const char *path) {
    for (size_t i = 0; cache && i < cache->count; ++i)
        if (strcmp(cache->assets[i].stamps[0].path, path) == 0) return cache->assets + i;
    return NULL;
}

mcv_result mcv_asset_cache_add(mcv_loader *asset, const double size[3], const mcv_json_path *place,
                               mcv_error *error) {
    mcv_asset_cache *cache = asset->cache;
    if (!cache) return MCV_OK;
    mcv_cached_asset *assets = realloc(cache->assets, (cache->count + 1) * sizeof *assets);
    if (!assets) return mcv_fail_memory(place, error);
    cache->assets = assets;
    mcv_cached_asset a = {.fingerprint = asset->fingerprint};
    if (size) {
        a.solid = mcv_scene_new(asset->file.key);
        if (!a.solid) return mcv_fail_memory(place, error);
        const mcv_result result =
            mcv_scene_add_mesh(a.solid, asset->scene->meshes + asset->solid, error);
        if (result != MCV_OK) mcv_scene_free(a.solid);
        MCV_TRY(result);
        memcpy(a.size, size, sizeof a.size);
    } else {
        a.root = json_incref(asset->root);
        a.gltf = asset->gltf;
        asset->is_cached = true;
    }
    a.stamps = asset->stamps;
    a.stamp_count = asset->stamp_count;
    asset->stamps = NULL;
    asset->stamp_count = 0;
    cache->assets[cache->count++] = a;
    ++cache->read;
    return MCV_OK;
}
