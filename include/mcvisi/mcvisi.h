/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MC ViSi: simulation of machine-vision systems. The public interface for C and C++.
 *
 *     mcv_error error = {""};
 *     mcv_session *session = NULL;
 *     mcv_rig *rig = NULL;
 *     mcv_picture *picture = NULL;
 *     if (mcv_session_open(NULL, &session, &error) == MCV_OK &&
 *         mcv_rig_open("part.gltf", &rig, &error) == MCV_OK &&
 *         mcv_rig_set(rig, "sensors/camera/fNumber", "8", &error) == MCV_OK &&
 *         mcv_session_render(session, rig, "{\"spp\": 64}", NULL, NULL, &picture, NULL, &error) ==
 *             MCV_OK)
 *         mcv_picture_write(picture, "part.exr", NULL, &error);
 *     if (error.text[0]) fprintf(stderr, "%s\n", error.text);
 *     mcv_picture_free(picture);
 *     mcv_rig_free(rig);
 *     mcv_session_close(session);
 *
 * Errors. A function that can fail returns an mcv_result and writes one sentence into the caller's
 * mcv_error: what happened, where (file, JSON path, option), what would be right. The error must
 * not be NULL. After a failure the outputs of the call are NULL or 0, and all handles are as they
 * were before. The only exception is an interrupted render: see mcv_session_render.
 *
 * Options. Options are a JSON object in UTF-8; NULL and "" stand for none. The keys are the names
 * of the options of the program's verb, with - or _ between words: {"expose-to": 0.8} and
 * {"expose_to": 0.8} are the same. A value is a text as on the command line ("10ms"), a number in
 * SI units, true or false, a list for options that may be repeated, and a list of numbers for sizes
 * and the like: [640, 480]. null leaves an option out; so does false, unless "off" is a word.
 * An unknown key is MCV_USAGE. mcv_options_schema gives the JSON schema of a verb's options.
 * Options are JSON and not structs, because the list of them grows: the interface then stays
 * binary compatible, and program, library and other languages read one list.
 *
 * Results. Reports are JSON objects in SI units, the same as the program prints with --json. What
 * the program says beside them, on standard error, is the member "notes": [{"severity", "text"}].
 * With the option {"json": false} it is the text that people read in its place, with such notes as
 * its first lines. Texts that the library makes are freed by mcv_text_free. Where a report is not
 * the only result, its pointer may be NULL.
 *
 * Files. Options that name output files (output, png …) make a call write them, too, with the
 * program's rules: whole or not at all, and never over an input.
 *
 * Handles. A handle belongs to whoever got it, who frees it once. All functions that free accept
 * NULL. The use of a handle that was freed is undefined, as with free(). Rigs and pictures do not
 * depend on the session that they were used with: they may outlive it.
 *
 * Threads. Different handles may be used in different threads at the same time: there is no global
 * state but a cache of compiled programs, behind a lock. A handle may move between threads. A
 * session serves one call at a time: a second call on it, from another thread or from inside one of
 * its callbacks, is MCV_USAGE. Functions that take a const rig or picture may run at the same time
 * on the same handle; a function that changes or frees a handle must be the only one that uses it.
 * Callbacks run in the thread of the call.
 *
 * Nothing here prints, exits, installs signal handlers or changes the locale of the process. A
 * decimal comma in the host's locale does not matter. Lengths are in metres, angles in radians,
 * times in seconds, unless a unit is given.
 */
#ifndef MCVISI_MCVISI_H
#define MCVISI_MCVISI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define MCV_API __attribute__((visibility("default")))
#else
#define MCV_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* X(NAME, exit code, meaning): what functions return, and what the program exits with. */
#define MCV_RESULTS(X) \
    X(OK, 0, "done") \
    X(FAILED, 1, "the work failed") \
    X(USAGE, 2, "wrong usage") \
    X(BAD_INPUT, 3, "bad input") \
    X(DEVICE, 4, "device trouble") \
    X(INTERRUPTED, 130, "interrupted") \
    X(TERMINATED, 143, "terminated")

typedef enum mcv_result {
#define MCV_X(name, code, meaning) MCV_##name = (code),
    MCV_RESULTS(MCV_X)
#undef MCV_X
} mcv_result;

/* One sentence for the user, UTF-8; empty while nothing has failed. The caller owns it. */
typedef struct mcv_error {
    char text[2048];
} mcv_error;

/* A device with its programs, and what consecutive renders have in common: assets, acceleration
 * structure, textures. */
typedef struct mcv_session mcv_session;

/* A scene as its JSON document (glTF), and the folder that its file names are relative to. */
typedef struct mcv_rig mcv_rig;

/* An image in memory: one or more parts of float32 values, and attributes. */
typedef struct mcv_picture mcv_picture;

/* --- the library --- */

/* The version, such as "0.2.0". A constant text. */
MCV_API const char *mcv_version(void);

/* Frees a text that the library has made. */
MCV_API void mcv_text_free(char *text);

/* The JSON schema (draft 4) of the options of a verb of the program, by its name there: "render",
 * "camera-model" … MCV_USAGE for what is no verb. The list of verbs and functions is in
 * docs/library.md. */
MCV_API mcv_result mcv_options_schema(const char *verb, char **schema, mcv_error *error);

/*
 * The OpenCL devices, as {"devices": [{"number": 0, "name": …, "type": "cpu", "version": …}, …]}:
 * what the option `device` takes. The list is empty where there is no OpenCL, and "message" says
 * why. The device "reference", the independent renderer on the CPU, is always there and not
 * listed.
 */
MCV_API mcv_result mcv_devices(char **report, mcv_error *error);

/* --- sessions --- */

/*
 * Opens a session. Its options count in every call on it that does not say otherwise: device,
 * precision, threads, schedule. The device is opened by the first call that needs it: mcv_session_
 * open succeeds without any OpenCL device. A session holds one device at a time; a call that names
 * another one closes the one before.
 */
MCV_API mcv_result mcv_session_open(const char *options, mcv_session **session, mcv_error *error);

/* Closes the session: device, programs and buffers are released. No call on it may be running. */
MCV_API void mcv_session_close(mcv_session *session);

/* --- rigs --- */

/* Reads a .gltf or .glb file. MCV_BAD_INPUT where it cannot be read or is no JSON; what is wrong
 * inside of the scene is told by the first call that uses it. */
MCV_API mcv_result mcv_rig_open(const char *path, mcv_rig **rig, mcv_error *error);

/* Takes the JSON document of a scene from memory, `size` bytes. File names in it are relative to
 * `folder`; NULL: the working folder. */
MCV_API mcv_result mcv_rig_parse(const char *json, size_t size, const char *folder, mcv_rig **rig,
                                 mcv_error *error);

/*
 * A rig around a part (.stl, .glb, .gltf): kind is "telecentric", "entocentric", "lightfield" or
 * "transparent"; options are those of `mcvisi new`. With "output" the rig is written there, with
 * the program's rules for existing files; without, no file is written and the rig lies in the
 * part's folder. *report: what was chosen, {"kind", "size", "magnification", "field_of_view": [w,
 * h], "light": {…}, …}.
 */
MCV_API mcv_result mcv_rig_new(const char *kind, const char *part, const char *options,
                               mcv_rig **rig, char **report, mcv_error *error);

/*
 * A lens file of a design program (.zmx, .seq) as a glTF document with exact surfaces, for scenes
 * to place; options are those of `mcvisi import`. *report: focal length, back focus, f-number and
 * what the file states of them.
 */
MCV_API mcv_result mcv_rig_import(const char *lens, const char *options, mcv_rig **rig,
                                  char **report, mcv_error *error);

/* A copy that can be changed on its own. */
MCV_API mcv_result mcv_rig_copy(const mcv_rig *rig, mcv_rig **copy, mcv_error *error);

/*
 * Changes the document, as --set PATH=VALUE does: "sensors/camera/fNumber", "8". The value is JSON,
 * or else a text, which may have a unit: "80mm". MCV_BAD_INPUT for a path that does not exist: the
 * sentence names what there is. The value itself, and the name of a new member of an MCVISI_
 * object, are checked by the first call that uses the scene.
 */
MCV_API mcv_result mcv_rig_set(mcv_rig *rig, const char *path, const char *value, mcv_error *error);

/* The JSON at a path, as written in the document; "" is all of it. MCV_BAD_INPUT for a path that
 * does not exist, or for a member that has its default value because it is not written. A path may
 * end before a member: "sensors/camera" is the whole sensor, "sensors" the list of them. */
MCV_API mcv_result mcv_rig_get(const mcv_rig *rig, const char *path, char **json, mcv_error *error);

/* The paths that mcv_rig_set takes and that the document has, as a JSON list of texts, in the
 * document's order: for completion. */
MCV_API mcv_result mcv_rig_paths(const mcv_rig *rig, char **json, mcv_error *error);

/* The path that the rig was read from or last saved to, or "". Valid until the rig is saved or
 * freed. */
MCV_API const char *mcv_rig_path(const mcv_rig *rig);

/* The folder that file names in the document are relative to. Valid until the rig is saved or
 * freed. */
MCV_API const char *mcv_rig_folder(const mcv_rig *rig);

/* Writes the document (.gltf, or .glb where it has a binary chunk), whole or not at all. It must go
 * into the rig's folder, because file names in it are relative: MCV_USAGE for another folder. */
MCV_API mcv_result mcv_rig_save(mcv_rig *rig, const char *path, mcv_error *error);

MCV_API void mcv_rig_free(mcv_rig *rig);

/* --- work on a rig --- */

/*
 * What was understood of the scene, and what is likely not meant: the report of `mcvisi check
 * --json`, with "findings": [{"severity", "path", "text"}]. Options are those of `mcvisi check`;
 * with "html" the page of the set-up is written, too. Needs no device. With {"defines": true} the
 * report is the -D options of the scene's OpenCL programs, or of all where `rig` is NULL.
 */
MCV_API mcv_result mcv_session_check(mcv_session *session, const mcv_rig *rig, const char *options,
                                     char **report, mcv_error *error);

/*
 * Which light makes a pixel: options are those of `mcvisi explain`; the page of "html" is written,
 * too. Needs no device: the reference renderer traces the paths. *report: {"value", "routes":
 * [{"name", "share": {"value", "uncertainty"}, "emitter", "surfaces": [{"node", "material",
 * "way"}], "path": [[x, y, z], …]}]}, from the camera to the emitter, the strongest first.
 */
MCV_API mcv_result mcv_session_explain(mcv_session *session, const mcv_rig *rig,
                                       const char *options, char **report, mcv_error *error);

/*
 * Compiles the OpenCL programs that renders of the rig need, unless the driver has them, so that
 * renders begin at once: options are those of `mcvisi warm`. *report: {"scene" (of a file),
 * "programs": [{"name": sensor, "type": device, "seconds", "features"}]}.
 */
MCV_API mcv_result mcv_session_warm(mcv_session *session, const mcv_rig *rig, const char *options,
                                    char **report, mcv_error *error);

/* What a running render tells. `size` is that of the struct; new members are added at the end. */
typedef struct mcv_progress {
    size_t size;
    double fraction;     /* done, 0 … 1; NaN while the kernels are compiled */
    double seconds;      /* since the call */
    double error;        /* relative error so far; infinite while it is not known */
    void *render;        /* for mcv_progress_picture */
    const char *sensor;  /* what is rendered */
    bool writing;        /* the samples are done, its files are written next */
    const char *preview; /* while kernels are compiled: the file that soon holds a coarse preview;
                            NULL: none does */
} mcv_progress;

/* Told after every pass of a render; false stops it. It runs in the thread of the render and may
 * call everything but functions on the same session. */
typedef bool mcv_progress_call(void *user, const mcv_progress *progress);

/* The picture so far; only from inside of the callback. *picture is NULL, with MCV_OK, before the
 * first sample of every pixel is complete. */
MCV_API mcv_result mcv_progress_picture(const mcv_progress *progress, mcv_picture **picture,
                                        mcv_error *error);

/* Writes the checkpoint of the render (the option "checkpoint") before it goes on; only from inside
 * of the callback. MCV_USAGE where it has none. */
MCV_API mcv_result mcv_progress_save(const mcv_progress *progress, mcv_error *error);

/*
 * Renders one sensor: the option "sensor", by default the only one; MCV_USAGE where there are
 * several. Options are those of `mcvisi render` without those that name files and those of the
 * camera; "checkpoint" names the file that the unfinished render is saved into, and "resume" goes
 * on with it. The picture has the parts "image" and "error" (its standard error), with {"parts":
 * "replicates"} also "replicate 0" …, and where its sampling was adaptive also "samples". Two
 * pictures of one seed have the same noise only with {"adaptive": "off"}. *stats: the summary of
 * `mcvisi render --json`.
 *
 * Where progress returns false: MCV_INTERRUPTED, with *picture of the samples so far, or NULL where
 * there are none; it is to be freed as any other.
 */
MCV_API mcv_result mcv_session_render(mcv_session *session, const mcv_rig *rig, const char *options,
                                      mcv_progress_call *progress, void *user,
                                      mcv_picture **picture, char **stats, mcv_error *error);

/* Told of work while it goes on: a report, as JSON or as the text for people, or only notes. It is
 * valid during the call. False stops the work. */
typedef bool mcv_told_call(void *user, const char *report);

/*
 * Renders every sensor, or the one of the option "sensor", into files, as `mcvisi render` does:
 * options are all of it. `told` gets what is odd in the scene as notes, before the first sample;
 * and of each sensor the summary, once its files are written. Where a callback returns false:
 * MCV_INTERRUPTED, with the files of the samples so far. Both callbacks may be NULL.
 */
MCV_API mcv_result mcv_session_render_files(mcv_session *session, const mcv_rig *rig,
                                            const char *options, mcv_progress_call *progress,
                                            mcv_told_call *told, void *user, mcv_error *error);

/*
 * Follows rays through the scene's smooth surfaces. `rays`: six numbers each, origin [m] and
 * direction in the world; NULL: those of the file of the option "rays". Options are those of
 * `mcvisi trace`; with "output" the table is written there, too. *csv: the table, a row per vertex;
 * may be NULL. *report: {"rays": n}, with what is odd in the scene as notes.
 */
MCV_API mcv_result mcv_session_trace(mcv_session *session, const mcv_rig *rig, const double *rays,
                                     size_t ray_count, const char *options, char **csv,
                                     char **report, mcv_error *error);

/*
 * Renders and measures many sets of parameters: options are those of `mcvisi sweep`. With "output"
 * the table, the experiment and the page are written beside each other; without, only the rows are
 * told: each set as it is measured, as {"set": n, "sets": all, "parameters": {name: value},
 * "metrics": {name: {"value", "uncertainty", "unit"}}, "samples", "error", "seconds", "message":
 * why the set failed, or null}; notes before the first set; and about ten times a second, while a
 * set is rendered, NULL. *report: the summary of `mcvisi sweep --json`. MCV_INTERRUPTED where told
 * returns false: rows so far stay in the table. MCV_FAILED, with a report, where all sets failed.
 */
MCV_API mcv_result mcv_session_sweep(mcv_session *session, const mcv_rig *rig, const char *options,
                                     mcv_told_call *told, void *user, char **report,
                                     mcv_error *error);

/*
 * How tolerances of parameters spread a metric: options are those of `mcvisi uncertainty`. Rows and
 * notes are told, and files written, as by mcv_session_sweep. *report: the summary of `mcvisi
 * uncertainty --json`, with the standard uncertainty of each metric by first order and by Monte
 * Carlo, each with its 95 % interval, and the effect of each parameter. MCV_USAGE for unknown
 * distributions and impossible correlations.
 */
MCV_API mcv_result mcv_session_uncertainty(mcv_session *session, const mcv_rig *rig,
                                           const char *options, mcv_told_call *told, void *user,
                                           char **report, mcv_error *error);

/*
 * Searches for the parameters at which metrics are largest or smallest: options are those of
 * `mcvisi optimize`. Rows and notes are told, and files written, as by mcv_session_sweep. *report:
 * the summary of `mcvisi optimize --json`, with the winner, its value from renders that have chosen
 * nothing, and its rivals, or the front of several objectives. MCV_BAD_INPUT for constraints that
 * allow nothing.
 */
MCV_API mcv_result mcv_session_optimize(mcv_session *session, const mcv_rig *rig,
                                        const char *options, mcv_told_call *told, void *user,
                                        char **report, mcv_error *error);

/* --- probability of detection --- */

/*
 * From which size on defects are found, of a table of sizes with signals or with hits and misses.
 * `table`: a CSV file such as `mcvisi sweep` writes. Options are those of `mcvisi pod`. *report:
 * {"answer": a sentence, "a90_bound", "a50" and "a90": {"value", "low", "high"}, "defects", "hits",
 * "curve": lists of size, probability and its two bounds, …}. A number that is null or not there is
 * not known; "answer" says why. MCV_USAGE and MCV_BAD_INPUT with a sentence for options and tables
 * that no probability can be told of.
 */
MCV_API mcv_result mcv_pod_table(const char *table, const char *options, char **report,
                                 mcv_error *error);

/* The same of arrays of `count` defects: sizes with signals or, where `hits`, with 1 and 0. Options
 * that name columns are refused. */
MCV_API mcv_result mcv_pod_values(const double *sizes, const double *values, size_t count,
                                  bool hits, const char *options, char **report, mcv_error *error);

/*
 * The same of an experiment, whose sets are rendered first. Options are those of `mcvisi sweep`:
 * "output", the table, must be there, and "resume" goes on with it. Their member "pod" is an object
 * of those of `mcvisi pod`. "noise" is "own" by default: with one noise for all defects its spread
 * would not be seen. Rows and notes are told as by mcv_session_sweep. *report: that of
 * mcv_pod_table. What is wrong with the member "pod" is MCV_USAGE before the first set.
 */
MCV_API mcv_result mcv_session_pod(mcv_session *session, const mcv_rig *rig, const char *options,
                                   mcv_told_call *told, void *user, char **report,
                                   mcv_error *error);

/* --- defects --- */

/*
 * Puts a defect onto the surface of a node, or inside of it. Its type is one of those of `mcvisi
 * defect`, such as "dent" or "bubble". Options are
 * those of `mcvisi defect` without "output". *report: {"defect", "type", "node", "position",
 * "normal", "size", "depth", "triangles" of the scene then}, with what is odd about it as notes.
 * MCV_BAD_INPUT where it lies off the surface or reaches round an edge.
 */
MCV_API mcv_result mcv_rig_add_defect(mcv_rig *rig, const char *type, const char *options,
                                      char **report, mcv_error *error);

/* --- camera models --- */

/*
 * The camera model of a sensor in a format that other programs read: options are those of `mcvisi
 * camera-model` without "import". *text: what the file holds; may be NULL with "output".
 * MCV_BAD_INPUT for a camera that the format cannot hold.
 */
MCV_API mcv_result mcv_rig_camera_model(const mcv_rig *rig, const char *options, char **text,
                                        mcv_error *error);

/*
 * Adds the camera of such a file, a sensor and its node with the pose. Options are those of `mcvisi
 * camera-model`, without "output". *report: {"sensor", "model", "size", …}. MCV_BAD_INPUT for
 * distortion other than 0, which sensors do not have.
 */
MCV_API mcv_result mcv_rig_add_camera(mcv_rig *rig, const char *file, const char *options,
                                      char **report, mcv_error *error);

/* --- parts of renders --- */

/*
 * Joins film files of parts of a render, which are written by the options "samples" and "film" of a
 * render, in any order: the picture has the bits of one render. Options are those of `mcvisi
 * merge`; with "output" the image is written, too. *picture and *report may be NULL; the report is
 * {"parts", "samples", "error", …}. MCV_BAD_INPUT names what differs between the parts, and samples
 * that are missing or there twice.
 */
MCV_API mcv_result mcv_films_merge(const char *const *files, size_t count, const char *options,
                                   mcv_picture **picture, char **report, mcv_error *error);

/*
 * Joins the tables of parts of a sweep (its option "range") in any order: "output" is the table,
 * beside which the experiment is written; "force" replaces one. *report, which may be NULL:
 * {"table", "tables", "rows"}, with a note of parts that are missing.
 */
MCV_API mcv_result mcv_tables_merge(const char *const *files, size_t count, const char *options,
                                    char **report, mcv_error *error);

/* --- pictures --- */

/* One part of a picture. The caller sets `size` to sizeof(mcv_part); the picture owns the rest,
 * which is valid and at the same address until the picture is freed. */
typedef struct mcv_part {
    size_t size;
    const char *name; /* "image", "error" … */
    uint32_t width, height, channels;
    const float *planes; /* [channel][row][column], rows from the top; channels are Y, or R, G, B */
} mcv_part;

/* Reads .exr, or grey values from .png, .tif, .tiff or .npy. */
MCV_API mcv_result mcv_picture_read(const char *path, mcv_picture **picture, mcv_error *error);

/*
 * A picture of values in memory, which are copied: planes [channel][row][column], 1 or 3 channels,
 * each side at most 32768. `deviation`: the standard uncertainty of each value in the same layout,
 * or NULL. Attributes: a JSON object of texts and numbers such as mcv_picture_attributes gives, or
 * NULL. MCV_BAD_INPUT for values that are not finite and for negative uncertainties.
 */
MCV_API mcv_result mcv_picture_make(uint32_t width, uint32_t height, uint32_t channels,
                                    const float *planes, const float *deviation,
                                    const char *attributes, mcv_picture **picture,
                                    mcv_error *error);

/*
 * Writes the picture, whole or not at all; the ending says how. .exr: all parts, values and
 * attributes. .png: a preview in 8 bits. Grey values of a camera (mcv_picture_camera) into .png,
 * .tif, .tiff or .npy: the values as they are, of 8 or 16 bits. Options: {"preview": true} writes
 * grey values as a preview, too; {"parts": ["image"]} only these parts into .exr.
 */
MCV_API mcv_result mcv_picture_write(const mcv_picture *picture, const char *path,
                                     const char *options, mcv_error *error);

MCV_API uint32_t mcv_picture_part_count(const mcv_picture *picture);

/* A part by its number from 0. MCV_USAGE where there is none or part->size is not set. */
MCV_API mcv_result mcv_picture_part(const mcv_picture *picture, uint32_t index, mcv_part *part,
                                    mcv_error *error);

/* All attributes as a JSON object: texts, numbers, lists of 2, 4 or 16 numbers. "mcvisi:unit" is
 * the unit of the values, "mcvisi:cameraModel" the camera model, itself JSON in a text. */
MCV_API mcv_result mcv_picture_attributes(const mcv_picture *picture, char **json,
                                          mcv_error *error);

MCV_API void mcv_picture_free(mcv_picture *picture);

/* --- work on pictures --- */

/* The grey values of a camera (EMVA 1288): options are those of `mcvisi camera`. The picture is of
 * whole numbers [DN], with the parts "error" and "render error". */
MCV_API mcv_result mcv_picture_camera(const mcv_picture *picture, const char *options,
                                      mcv_picture **grey, char **report, mcv_error *error);

/*
 * Measures: options are those of `mcvisi measure`, the report is that of `mcvisi measure --json`.
 * `minus`: measure in the difference picture - minus, or NULL. `rig`: the scene of a picture whose
 * attributes do not give the scale, and for "nominal", or NULL.
 */
MCV_API mcv_result mcv_picture_measure(const mcv_picture *picture, const mcv_picture *minus,
                                       const mcv_rig *rig, const char *options, char **report,
                                       mcv_error *error);

/*
 * Tells whether two renders of the same picture differ by more than their noise. *different: it;
 * *difference: (a - b) in units of its standard error; *report: that of `mcvisi compare --json`;
 * each may be NULL. Options: "output", a picture of the difference. Render scenes first, with
 * {"parts": "replicates"} for rank tests.
 */
MCV_API mcv_result mcv_picture_compare(const mcv_picture *a, const mcv_picture *b,
                                       const char *options, bool *different,
                                       mcv_picture **difference, char **report, mcv_error *error);

/*
 * How well a camera can tell the defect of the picture `with` from its noise: renders of one scene
 * with and without it, both with all their replicates ("parts": "replicates"). With {"adaptive":
 * "off"} and one seed most of their noise cancels. Options are those of `mcvisi detect`.
 * *visible (or NULL): a picture of |difference| in deviations of the noise.
 * *report: {"detectability": {"value", "low", "high"}, "contrast", "found", "visible", …}.
 */
MCV_API mcv_result mcv_picture_detect(const mcv_picture *with, const mcv_picture *without,
                                      const char *options, mcv_picture **visible, char **report,
                                      mcv_error *error);

/*
 * Finds the laser line in images, files of one camera, and the heights of the part that it lights:
 * a profile of each. Options are those of `mcvisi triangulate`: "laser", the node in the images'
 * headers whose x-z plane is the light's; "output", a list of files. *report: how many places are
 * seen, missing or double, and their uncertainty.
 */
MCV_API mcv_result mcv_images_triangulate(const char *const *images, size_t count,
                                          const char *options, char **report, mcv_error *error);

/*
 * Renders the profiles of a laser head that moves over a part, exposes them with speckle and noise,
 * and finds the heights. Options are those of `mcvisi scan`; with "output" its files are written,
 * too. The picture has the heights [m] as part "image" and their standard uncertainty as "error", a
 * row for each profile; "x", "y" [m], "place" [pixels] and "mask". NaN: not seen. Where progress
 * returns false: MCV_INTERRUPTED, without a picture. *report: how many places are seen, the head's
 * figures, and with "budget" what each cause brings to the error; may be NULL.
 */
MCV_API mcv_result mcv_session_scan(mcv_session *session, const mcv_rig *rig, const char *options,
                                    mcv_progress_call *progress, void *user, mcv_picture **picture,
                                    char **report, mcv_error *error);

/* The sub-aperture views of a light field image, side by side. Options are those of `mcvisi
 * lightfield views`: {"angular": "9x9"} where the attributes do not tell. */
MCV_API mcv_result mcv_picture_views(const mcv_picture *picture, const char *options,
                                     mcv_picture **views, char **report, mcv_error *error);

/* The Earth Mover's gradient of a light field image. Options are those of `mcvisi lightfield
 * emd-gradient`. */
MCV_API mcv_result mcv_picture_emd_gradient(const mcv_picture *picture, const char *options,
                                            mcv_picture **gradient, char **report,
                                            mcv_error *error);

/* --- light transport --- */

/* A light transport matrix: what each element of the emitters brings to each pixel. */
typedef struct mcv_transport mcv_transport;

/*
 * Renders the matrix of one sensor: the option "sensor", by default the only one. Options are those
 * of `mcvisi transport`; with "output" and "white" its files are written, too. An element is an
 * emitter, or a pixel of its image. Where progress returns false: MCV_INTERRUPTED, without a
 * matrix. *report: its size, its elements, its entries; may be NULL.
 */
MCV_API mcv_result mcv_session_transport(mcv_session *session, const mcv_rig *rig,
                                         const char *options, mcv_progress_call *progress,
                                         void *user, mcv_transport **transport, char **report,
                                         mcv_error *error);

/*
 * Deflectometry: fringes on a screen, seen in a mirroring part, give its slopes and heights.
 * Options are those of `mcvisi deflectometry`; "plane" is required, and with "output" and "png" its
 * files are written, too. The picture has the heights [m] as part "image" and their standard
 * uncertainty as "error"; "slope", "slope error", "place" [m], "screen" [its pixels] and
 * "modulation" have two channels. NaN: not seen. Where progress returns false: MCV_INTERRUPTED,
 * without a picture. *report may be NULL.
 */
MCV_API mcv_result mcv_session_deflectometry(mcv_session *session, const mcv_rig *rig,
                                             const char *options, mcv_progress_call *progress,
                                             void *user, mcv_picture **picture, char **report,
                                             mcv_error *error);

/* Reads .npz; writes .npz or .mtx, whole or not at all. */
MCV_API mcv_result mcv_transport_read(const char *path, mcv_transport **transport,
                                      mcv_error *error);
MCV_API mcv_result mcv_transport_write(const mcv_transport *transport, const char *path,
                                       mcv_error *error);

/* The header as JSON: {"width", "height", "channels", "replicates", "samples", "kept", "elements":
 * [{"emitter", "type", "first", "width", "height", "radiance", "to_world"}], "attributes"}. */
MCV_API mcv_result mcv_transport_header(const mcv_transport *transport, char **json,
                                        mcv_error *error);

/*
 * The entries in compressed rows. Row (pixel, channel) is number pixel * channels + channel; its
 * entries are row_begins[row] … row_begins[row + 1] - 1, in ascending columns. The caller sets
 * `size` to sizeof(mcv_matrix_entries); the matrix owns the rest.
 */
typedef struct mcv_matrix_entries {
    size_t size;
    size_t row_count, column_count, element_count, replicate_count, entry_count;
    const uint64_t *row_begins;
    const uint32_t *columns; /* elements; element_count: what "keep" has dropped */
    const double *values;    /* of the image, for a pattern of 1 */
    const float *replicates; /* [entry][replicate]: the value by each replicate */
    const float *pattern;    /* [element][channel]: that of the scene */
} mcv_matrix_entries;

MCV_API mcv_result mcv_transport_entries(const mcv_transport *transport,
                                         mcv_matrix_entries *entries, mcv_error *error);

/*
 * The image of a pattern, [element][channel] of `count` values; NULL: that of the options of
 * `mcvisi relight`, by default the scene's. The picture has the parts "image" and "error", from the
 * replicates. *report may be NULL; with "fit" it has "weights" of the emitters, and the figures of
 * "region".
 */
MCV_API mcv_result mcv_transport_relight(const mcv_transport *transport, const float *pattern,
                                         size_t count, const char *options, mcv_picture **picture,
                                         char **report, mcv_error *error);

/*
 * The images of a sequence of patterns, one after the other: option "sequence" of `mcvisi relight`.
 * *count: how many they are. pictures: `room` places for them; NULL: *count alone is wanted.
 */
MCV_API mcv_result mcv_transport_sequence(const mcv_transport *transport, const char *options,
                                          mcv_picture **pictures, size_t room, size_t *count,
                                          char **report, mcv_error *error);

/*
 * How a part turns light aside, by options of `mcvisi deflection`: a matrix with the directions of
 * a light field emitter or a light field camera. `reference`: of the same set-up without the part,
 * or NULL. *picture has the parts "image" (deflection, x and y), "error", "covariance", "covariance
 * error", "transmitted", "transmitted error" and "lost". *histogram, or NULL: the shares of the
 * directions at each place, as of a light field camera. *report may be NULL.
 */
MCV_API mcv_result mcv_transport_deflection(const mcv_transport *transport,
                                            const mcv_transport *reference, const char *options,
                                            mcv_picture **picture, mcv_picture **histogram,
                                            char **report, mcv_error *error);

/*
 * The pattern under which the flawless part of the matrix looks even, by options of `mcvisi
 * inverse-pattern`. *pattern has a pixel for each of the emitter, from 0 to 1, and the part
 * "error". *report may be NULL; it has the figures of "region" for the flawless part, and for that
 * of "defect".
 */
MCV_API mcv_result mcv_transport_inverse(const mcv_transport *transport, const char *options,
                                         mcv_picture **pattern, char **report, mcv_error *error);

MCV_API void mcv_transport_free(mcv_transport *transport);

#ifdef __cplusplus
}
#endif
#endif
