/* SPDX-License-Identifier: Apache-2.0 */
#include "film/film_file.h"

#include "core/json.h"
#include "core/output_file.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "film files are little-endian");

static const char MAGIC[8] = {'M', 'C', 'V', 'F', 'I', 'L', 'M', '1'};
enum { MOST_TEXT = 1 << 24, PIECE = 1 << 24, MOST_SIDE = 1 << 16, SECTIONS = 5 };

static size_t padded(size_t bytes) { return (bytes + 7) / 8 * 8; }

/* The sections of a file; those that it has not are empty. */
typedef struct section {
    void **to;
    size_t bytes;
} section;

static void list_sections(mcv_film *film, mcv_round *round, const bool has[SECTIONS],
                          section sections[SECTIONS]) {
    const size_t pixels = (size_t)film->width * film->height,
                 values = 8 * pixels * film->channels * film->replicates;
    void **const places[SECTIONS] = {has[1] ? (void **)&film->camera_sums : (void **)&film->sums,
                                     (void **)&film->splats, (void **)&film->levels,
                                     (void **)&round->sums, (void **)&round->splats};
    for (int i = 0; i < SECTIONS; ++i)
        sections[i] = (section){places[i], !has[i] ? 0 : i == 2 ? padded(pixels) : values};
}

/* --- writing --- */

typedef struct writer {
    mcv_output output;
    uLong checksum;
    mcv_error *error;
} writer;

static mcv_result put(writer *w, const void *bytes, size_t count) {
    for (const char *next = bytes; count > 0;) {
        const size_t piece = count < PIECE ? count : PIECE;
        w->checksum = crc32(w->checksum, (const Bytef *)next, (uInt)piece);
        MCV_TRY(mcv_output_write(&w->output, next, piece, w->error));
        next += piece;
        count -= piece;
    }
    return MCV_OK;
}

static mcv_result put_padding(writer *w, size_t bytes) {
    static const char zeros[8];
    return put(w, zeros, padded(bytes) - bytes);
}

static mcv_result put_all(writer *w, const mcv_film *film, const mcv_round *round,
                          const char *text) {
    bool has[SECTIONS] = {true, film->splats, film->levels, round->sums,
                          round->sums && round->splats};
    mcv_film borrowed = *film;
    mcv_round part = *round;
    section sections[SECTIONS];
    const uint64_t length = strlen(text);
    const size_t pixels = (size_t)film->width * film->height;
    MCV_TRY(put(w, MAGIC, sizeof MAGIC));
    MCV_TRY(put(w, &length, sizeof length));
    MCV_TRY(put(w, text, length));
    MCV_TRY(put_padding(w, length));
    list_sections(&borrowed, &part, has, sections);
    for (int i = 0; i < SECTIONS; ++i) {
        if (sections[i].bytes == 0) continue;
        MCV_TRY(put(w, *sections[i].to, i == 2 ? pixels : sections[i].bytes));
        if (i == 2) MCV_TRY(put_padding(w, pixels));
    }
    const uint64_t checksum = w->checksum;
    return mcv_output_write(&w->output, &checksum, sizeof checksum, w->error);
}

static json_t *whole(uint64_t value) { return json_integer((json_int_t)value); }

static char *describe(const mcv_film *film, const mcv_round *round, const json_t *facts) {
    json_t *document = json_object(),
           *sizes =
               json_pack("{s:o, s:o, s:o, s:o, s:o, s:b, s:f, s:b}", "width", whole(film->width),
                         "height", whole(film->height), "channels", whole(film->channels),
                         "replicates", whole(film->replicates), "samples", whole(film->samples),
                         "splats", film->splats != NULL, "splat_value",
                         film->splats ? film->splat_value : 0.0, "levels", film->levels != NULL);
    if (round->count)
        mcv_json_put(&sizes, "round",
                     json_pack("{s:o, s:o, s:o, s:o, s:b}", "first", whole(round->first), "count",
                               whole(round->count), "class", whole(round->class), "sets",
                               whole(round->sets), "begun", round->sums != NULL));
    mcv_json_put(&document, "film", sizes);
    char *text = document && json_object_update(document, (json_t *)facts) == 0
                     ? json_dumps(document, JSON_COMPACT | JSON_REAL_PRECISION(17))
                     : NULL;
    json_decref(document);
    return text;
}

mcv_result mcv_film_file_write(const char *path, const mcv_film *film, const mcv_round *round,
                               const json_t *facts, mcv_error *error) {
    writer w = {.checksum = crc32(0, NULL, 0), .error = error};
    char *text = describe(film, round, facts);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory for its text", path);
    mcv_result result = mcv_output_open(&w.output, path, error);
    if (result == MCV_OK) {
        result = put_all(&w, film, round, text);
        if (result == MCV_OK)
            result = mcv_output_commit(&w.output, error);
        else
            mcv_output_discard(&w.output);
    }
    free(text);
    return result;
}

/* --- reading --- */

typedef struct reader {
    const char *path;
    FILE *file;
    uint64_t size, at;
    uLong checksum;
    mcv_error *error;
} reader;

static mcv_result cut(const reader *r) {
    return mcv_fail(r->error, MCV_BAD_INPUT,
                    "%s: is no whole film file: it is cut or damaged; render it again", r->path);
}

static mcv_result get(reader *r, void *bytes, size_t count) {
    for (char *next = bytes; count > 0;) {
        const size_t piece = count < PIECE ? count : PIECE;
        if (fread(next, 1, piece, r->file) != piece) return cut(r);
        r->checksum = crc32(r->checksum, (const Bytef *)next, (uInt)piece);
        r->at += piece;
        next += piece;
        count -= piece;
    }
    return MCV_OK;
}

static mcv_result get_text(reader *r, json_t **facts) {
    char magic[sizeof MAGIC];
    uint64_t length;
    json_error_t wrong;
    if (r->size < 32) return cut(r);
    MCV_TRY(get(r, magic, sizeof magic));
    if (memcmp(magic, MAGIC, sizeof MAGIC) != 0)
        return mcv_fail(r->error, MCV_BAD_INPUT,
                        "%s: is no film file: give one of --checkpoint or --film", r->path);
    MCV_TRY(get(r, &length, sizeof length));
    if (length > MOST_TEXT || padded(length) > r->size - 24) return cut(r);
    char *text = malloc(padded(length) + 1);
    if (!text) return mcv_fail(r->error, MCV_FAILED, "%s: no memory for its text", r->path);
    const mcv_result result = get(r, text, padded(length));
    if (result == MCV_OK) *facts = json_loadb(text, length, JSON_REJECT_DUPLICATES, &wrong);
    free(text);
    return result != MCV_OK ? result : json_is_object(*facts) ? MCV_OK : cut(r);
}

static mcv_result read_sizes(const reader *r, const json_t *sizes, mcv_film_file *f,
                             bool has[SECTIONS]) {
    const mcv_json_path root = mcv_place_file(r->path), place = mcv_json_path_key(&root, "film");
    const uint64_t most = (uint64_t)1 << 40;
    mcv_film *film = &f->film;
    uint64_t size[4] = {0};
    static const char *const names[] = {"width", "height", "channels", "replicates"};
    static const uint64_t limits[] = {MOST_SIDE, MOST_SIDE, 3, MCV_MAX_REPLICATES};
    json_t *round = NULL;
    for (int i = 0; i < 4; ++i) {
        MCV_TRY(mcv_json_uint(sizes, names[i], 1, limits[i], size + i, &place, r->error));
        if (size[i] == 0) return cut(r);
    }
    film->width = (uint32_t)size[0];
    film->height = (uint32_t)size[1];
    film->channels = (uint32_t)size[2];
    film->replicates = (uint32_t)size[3];
    MCV_TRY(mcv_json_uint(sizes, "samples", 0, most, &film->samples, &place, r->error));
    MCV_TRY(mcv_json_bool(sizes, "splats", has + 1, &place, r->error));
    MCV_TRY(mcv_json_bool(sizes, "levels", has + 2, &place, r->error));
    MCV_TRY(mcv_json_number(sizes, "splat_value", 0, 1e300, &film->splat_value, &place, r->error));
    MCV_TRY(mcv_json_object(sizes, "round", &round, &place, r->error));
    if (!round) return MCV_OK;
    const mcv_json_path in = mcv_json_path_key(&place, "round");
    mcv_round *part = &f->round;
    MCV_TRY(mcv_json_uint(round, "first", 0, most, &part->first, &in, r->error));
    MCV_TRY(mcv_json_uint(round, "count", 1, most, &part->count, &in, r->error));
    MCV_TRY(mcv_json_uint(round, "class", 0, most, &part->class, &in, r->error));
    MCV_TRY(mcv_json_uint(round, "sets", 0, most, &part->sets, &in, r->error));
    return mcv_json_bool(round, "begun", has + 3, &in, r->error);
}

/* The sums of camera paths and of light paths together. */
static mcv_result add_splats(const reader *r, mcv_film *film) {
    const size_t count = mcv_film_values(film);
    film->sums = malloc(count * sizeof *film->sums);
    if (!film->sums) return mcv_fail(r->error, MCV_FAILED, "%s: no memory for its sums", r->path);
    for (size_t i = 0; i < count; ++i)
        film->sums[i] = film->camera_sums[i] + film->splat_value * (double)film->splats[i];
    return MCV_OK;
}

static mcv_result get_sections(reader *r, const section sections[SECTIONS]) {
    uint64_t checksum;
    for (int i = 0; i < SECTIONS; ++i) {
        if (sections[i].bytes == 0) continue;
        *sections[i].to = malloc(sections[i].bytes);
        if (!*sections[i].to)
            return mcv_fail(r->error, MCV_FAILED, "%s: no memory for its sums, %.3g GB", r->path,
                            1e-9 * (double)r->size);
        MCV_TRY(get(r, *sections[i].to, sections[i].bytes));
    }
    const uint64_t expected = r->checksum;
    MCV_TRY(get(r, &checksum, sizeof checksum));
    return checksum == expected ? MCV_OK : cut(r);
}

static mcv_result read_open(reader *r, bool sums, mcv_film_file *f) {
    bool has[SECTIONS] = {true};
    section sections[SECTIONS];
    MCV_TRY(get_text(r, &f->facts));
    json_t *sizes = json_object_get(f->facts, "film");
    if (!json_is_object(sizes)) return cut(r);
    MCV_TRY(read_sizes(r, sizes, f, has));
    has[4] = has[3] && has[1];
    list_sections(&f->film, &f->round, has, sections);
    uint64_t bytes = r->at + 8;
    for (int i = 0; i < SECTIONS; ++i) bytes += sections[i].bytes;
    if (bytes != r->size) return cut(r);
    if (!sums) return MCV_OK;
    MCV_TRY(get_sections(r, sections));
    for (size_t i = 0; has[2] && i < (size_t)f->film.width * f->film.height; ++i)
        if (f->film.levels[i] < -3 || f->film.levels[i] > 3) return cut(r);
    return has[1] ? add_splats(r, &f->film) : MCV_OK;
}

static mcv_result read_file(const char *path, bool sums, mcv_film_file *f, mcv_error *error) {
    reader r = {.path = path, .checksum = crc32(0, NULL, 0), .error = error};
    *f = (mcv_film_file){.facts = NULL};
    MCV_TRY(mcv_file_open(path, &r.file, &r.size, error));
    const mcv_result result = read_open(&r, sums, f);
    fclose(r.file);
    if (result != MCV_OK) mcv_film_file_free(f);
    return result;
}

mcv_result mcv_film_file_read(const char *path, mcv_film_file *file, mcv_error *error) {
    return read_file(path, true, file, error);
}

mcv_result mcv_film_file_look(const char *path, mcv_film_file *file, mcv_error *error) {
    return read_file(path, false, file, error);
}

void mcv_film_file_free(mcv_film_file *file) {
    mcv_film_free(&file->film);
    free(file->round.sums);
    free(file->round.splats);
    json_decref(file->facts);
    *file = (mcv_film_file){.facts = NULL};
}
