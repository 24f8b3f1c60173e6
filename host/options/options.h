/* SPDX-License-Identifier: Apache-2.0 */
/* The verbs and options of the program, each listed once. Parsing (options/command.h), help,
 * messages and JSON schemas follow from the lists. */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_H
#define MCVISI_HOST_OPTIONS_OPTIONS_H

#include "options/options_camera.h"
#include "options/options_defect.h"
#include "options/options_deflection.h"
#include "options/options_deflectometry.h"
#include "options/options_detect.h"
#include "options/options_experiment.h"
#include "options/options_inverse.h"
#include "options/options_lightfield.h"
#include "options/options_exec.h"
#include "options/options_long.h"
#include "options/options_pod.h"
#include "options/options_scan.h"
#include "options/options_transport.h"
#include "options/options_triangulate.h"

#include <stddef.h>
#include <stdint.h>

/* X(verb, VERB, "name", "arguments", "what it does"). A verb has no, one or two arguments; an
 * optional one stands in []. */
#define MCV_VERBS(X) \
    X(render, RENDER, "render", "SCENE", \
      "render every sensor of a scene into OpenEXR and PNG images") \
    X(new, NEW, "new", "telecentric|entocentric|lightfield|transparent|laser PART", \
      "write a rig around a part (.stl, .glb, .gltf): standard optics that frame it, and a light " \
      "(transparent: a light field camera and a parallel panel behind the part; laser: a laser " \
      "line, and a camera at its side whose film is tilted)") \
    X(check, CHECK, "check", "[SCENE]", \
      "print how a scene was understood: optics, emitters, materials, features with their " \
      "causes, stages, findings") \
    X(trace, TRACE, "trace", "SCENE", \
      "trace given rays through a scene's smooth surfaces and print every vertex of their paths") \
    X(compare, COMPARE, "compare", "A B", \
      "test whether two renders of the same picture (OpenEXR images or scenes) differ by more " \
      "than their noise; exit code 1 if they do") \
    X(camera, CAMERA, "camera", "IMAGE.exr", \
      "convert irradiance or radiance to the grey values of a camera, with its noise (EMVA 1288)") \
    X(camera_model, CAMERA_MODEL, "camera-model", "[RIG]", \
      "write the camera model of a sensor for OpenCV, ROS, HALCON or COLMAP, or take such a " \
      "camera into a rig") \
    X(measure, MEASURE, "measure", "IMAGE", \
      "measure in an image: regions, contrasts, edges and their sharpness, lines, widths and " \
      "circles, each with its standard uncertainty") \
    X(triangulate, TRIANGULATE, "triangulate", "IMAGE…", \
      "find the laser line in images of a camera, and compute the heights of the part along it: " \
      "one profile per image") \
    X(scan, SCAN, "scan", "SCENE", \
      "render the profiles of a laser head that moves over a part, expose them with speckle and " \
      "noise, and find the heights; with --budget also the error by each cause") \
    X(sweep, SWEEP, "sweep", "RIG|EXPERIMENT.json", \
      "render a scene with many sets of parameters and measure in each image; the result is a " \
      "table and a page of plots with error bars") \
    X(pod, POD, "pod", "TABLE.csv|EXPERIMENT.json", \
      "compute from which size on defects are found, and with which confidence " \
      "(MIL-HDBK-1823A), from a table of sizes with signals or with hits and misses; an " \
      "experiment of `mcvisi sweep` is rendered first, or continued") \
    X(uncertainty, UNCERTAINTY, "uncertainty", "RIG|EXPERIMENT.json", \
      "propagate tolerances of a scene's parameters to what is measured: by first order and by " \
      "Monte Carlo, with the contribution of each tolerance") \
    X(optimize, OPTIMIZE, "optimize", "RIG|EXPERIMENT.json", \
      "search for the parameters of a scene at which a metric is largest or smallest, with few " \
      "renders; fresh renders, which the search has not used, confirm the result") \
    X(merge, MERGE, "merge", "PART.film…|PART.csv…", \
      "join the films of parts of a render (render --samples A:B --film) to its image, with the " \
      "bits of one render; or the tables of parts of a sweep (--range I/N) to one") \
    X(lightfield, LIGHTFIELD, "lightfield", "views|emd-gradient IMAGE.exr", \
      "show a light field image as its sub-aperture views, or its Earth Mover's gradient, in " \
      "which defects stand out") \
    X(transport, TRANSPORT, "transport", "SCENE", \
      "render the light transport matrix of a scene: what each lamp, or each pixel of a " \
      "projector's, light field's or lamp's image, contributes to each pixel of the camera") \
    X(relight, RELIGHT, "relight", "MATRIX.npz", \
      "compute the image under other lamps or another pattern from a light transport matrix, " \
      "with its standard error, without tracing rays") \
    X(deflection, DEFLECTION, "deflection", "MATRIX.npz|SCENE", \
      "show how a transparent part deflects light: at each place the histogram of directions, " \
      "their mean and covariance, and the share of the light that is lost") \
    X(inverse, INVERSE, "inverse-pattern", "MATRIX.npz", \
      "compute the pattern under which a flawless part looks even and defects stand out, from " \
      "the part's light transport matrix") \
    X(deflectometry, DEFLECTOMETRY, "deflectometry", "SCENE", \
      "measure a mirroring part by fringes on a screen: its slopes and heights with their " \
      "uncertainties, and the period of the fringes for which these are least") \
    X(explain, EXPLAIN, "explain", "SCENE", \
      "list the paths that make a pixel: which surfaces they meet, which emitter they come from, " \
      "and their shares of its light") \
    X(import, IMPORT, "import", "LENS.zmx|LENS.seq", \
      "convert a lens file of a design program to a glTF file with exact surfaces, which scenes " \
      "can place") \
    X(defect, DEFECT, "defect", "RIG TYPE", \
      "put a defect onto the surface of a node (dent, bump, scratch, dig, burr, chip, " \
      "missingPart, stain, roughPatch) or inside it (bubble, inclusion, stria, crack)") \
    X(detect, DETECT, "detect", "WITH.exr WITHOUT.exr", \
      "state how well a camera can distinguish a defect from its noise: contrast and " \
      "detectability d', from renders with and without the defect") \
    X(warm, WARM, "warm", "[SCENE…]", \
      "compile ahead what renders of these scenes need, so that they begin at once; without a " \
      "scene, what rigs of `mcvisi new` need") \
    X(devices, DEVICES, "devices", "", "list the OpenCL devices and their numbers") \
    X(help, HELP, "help", "[VERB]", "explain a verb and its options")

enum {
#define MCV_X(verb, VERB, name, argument, doc) MCV_VERB_##VERB,
    MCV_VERBS(MCV_X)
#undef MCV_X
        MCV_VERB_COUNT
};

/* Sets of verbs that take an option. */
enum {
#define MCV_X(verb, VERB, name, argument, doc) MCV_IN_##VERB = 1 << MCV_VERB_##VERB,
    MCV_VERBS(MCV_X)
#undef MCV_X
    /* Verbs that render many sets. */
    MCV_IN_EXPERIMENTS = MCV_IN_SWEEP | MCV_IN_UNCERTAINTY | MCV_IN_OPTIMIZE,
    MCV_IN_RENDERS = MCV_IN_RENDER | MCV_IN_EXPERIMENTS, /* verbs that render scenes */
    /* That record transport matrices. */
    MCV_IN_MATRICES = MCV_IN_TRANSPORT | MCV_IN_DEFLECTION | MCV_IN_DEFLECTOMETRY,
    MCV_IN_PATHS = MCV_IN_RENDERS | MCV_IN_COMPARE | MCV_IN_MATRICES, /* that trace paths */
    MCV_IN_PROGRAMS = MCV_IN_PATHS | MCV_IN_WARM | MCV_IN_SCAN, /* that choose OpenCL programs */
    MCV_IN_FIGURES = MCV_IN_MEASURE | MCV_IN_EXPERIMENTS,
    MCV_IN_GREY = MCV_IN_RENDERS | MCV_IN_CAMERA | MCV_IN_SCAN,
    MCV_IN_EXPOSES = MCV_IN_GREY | MCV_IN_DETECT,
    MCV_IN_PROFILES = MCV_IN_TRIANGULATE | MCV_IN_SCAN, /* that find heights */
    MCV_IN_SCENES = MCV_IN_PROGRAMS | MCV_IN_CHECK | MCV_IN_TRACE | MCV_IN_MEASURE |
                    MCV_IN_EXPLAIN | MCV_IN_CAMERA_MODEL
};

/*
 * X(kind, field, "name", letter, "argument", verbs, default, min, max, "doc")
 *
 * The kinds are
 *     flag      present or not
 *     text      a string
 *     list      a string; the option may be repeated
 *     number    above min and at most max
 *     time      such a number, in seconds or with a unit
 *     bytes     such a number, in bytes or with a unit
 *     channels  one such number or three
 *     lengths   one such number or three, in metres or with units
 *     count     an integer from min to max
 *     size      two counts WxH
 *     range     two counts A:B with A < B
 *     choice    one of the words in the argument, stored as its index; where `on` is one of them
 * the option may stand without a value, which means that one The default is written as on the
 * command line; without one the field is zero.
 */
#define MCV_OPTIONS(X) \
    X(text, exr, "output", 'o', "F.exr", MCV_IN_RENDER, NULL, 0, 0, \
      "the OpenEXR image; its second part is the standard error; by default it is named after " \
      "the scene, and the sensor if there are several") \
    X(count, lasers, "lasers", 0, "Q", MCV_IN_RENDER, NULL, 1, 64, \
      "the light of the scene's lasers alone, with Q x Q sub-pixels for each pixel: what " \
      "`camera --speckle` needs") \
    X(text, png, "png", 0, "F.png", MCV_IN_RENDER | MCV_IN_MERGE, NULL, 0, 0, \
      "the preview; by default the name of the OpenEXR image with .png") \
    X(choice, parts, "parts", 0, "error|replicates", MCV_IN_RENDER | MCV_IN_MERGE, "error", 0, 0, \
      "parts of the OpenEXR file beside the image: error, its standard error; replicates, " \
      "also the means of all replicates, which `mcvisi compare` needs for rank tests") \
    MCV_LONG_OPTIONS(X) \
    X(text, rig, "output", 'o', "RIG.gltf", MCV_IN_NEW, NULL, 0, 0, \
      "the rig; the part must lie in its folder or below; by default PART-KIND.gltf beside " \
      "the part") \
    X(text, lens, "output", 'o', "LENS.gltf", MCV_IN_IMPORT, NULL, 0, 0, \
      "the file to write; by default the name of the lens file with .gltf") \
    X(list, index, "index", 0, "GLASS=N", MCV_IN_IMPORT, NULL, 0, 0, \
      "the refractive index of a glass that is not in the catalogue; may be repeated") \
    X(choice, curvature, "curvature", 0, "auto|radius|curvature", MCV_IN_IMPORT, "auto", 0, 0, \
      "meaning of the numbers of a .seq file's surfaces; auto: as its RDM says, else the one " \
      "that focuses at the file's image") \
    X(flag, force, "force", 0, NULL, MCV_IN_NEW, NULL, 0, 0, \
      "replace an existing rig that differs") \
    X(text, unit, "unit", 0, "nm|um|mm|cm|m|inch", MCV_IN_NEW, NULL, 0, 0, \
      "unit of the part's lengths; required for .stl files, which do not state it; glTF has " \
      "metres") \
    X(choice, light, "light", 0, "auto|backlight|ring|darkfield|coaxial|dome", MCV_IN_NEW, "auto", \
      0, 0, \
      "auto: a backlight for telecentric and transparent, else a ring around the view; " \
      "darkfield: a low ring close to the part") \
    X(text, material, "material", 0, "M", MCV_IN_NEW, NULL, 0, 0, \
      "material of the whole part, in place of its own: a metal (aluminium), a glass (N-BK7) " \
      "or a type without required parameters (mirror); by default .stl files are diffuse; for " \
      "transparent they are N-BK7, and so is a glTF part that passes no light") \
    X(text, view, "view", 0, "SIDE|X,Y,Z", MCV_IN_NEW, NULL, 0, 0, \
      "side that faces the camera, in the part's coordinates: front (+z), back (-z), right " \
      "(+x), left (-x), top (+y), bottom (-y), or a direction; by default along the part's " \
      "shortest dimension") \
    X(size, film, "resolution", 0, "WxH", MCV_IN_NEW, NULL, 1, 16384, \
      "pixels of the camera; macro pixels of a light field camera") \
    X(text, pixel_size, "pixel-size", 0, "P", MCV_IN_NEW | MCV_IN_CAMERA_MODEL, NULL, 0, 0, \
      "width of a pixel, a length such as 3.45um; camera-model --import: where the file does " \
      "not state it (5um)") \
    X(text, field_of_view, "field-of-view", 0, "W", MCV_IN_NEW, NULL, 0, 0, \
      "width of the field in the plane in focus, such as 60mm; or give --magnification") \
    X(number, magnification, "magnification", 0, "M", MCV_IN_NEW, NULL, 0, 1e4, \
      "image size over object size") \
    X(text, focal_length, "focal-length", 0, "F", MCV_IN_NEW, NULL, 0, 0, \
      "focal length, such as 25mm") \
    X(text, working_distance, "working-distance", 0, "W", MCV_IN_NEW, NULL, 0, 0, \
      "distance from the lens to the plane in focus, which is the middle of the part, such as " \
      "110mm") \
    X(number, f_number, "f-number", 0, "N", MCV_IN_NEW, NULL, 0, 1e4, \
      "the working f-number, on the image side") \
    X(text, sensor, "sensor", 0, "NAME", \
      MCV_IN_EXPLAIN | MCV_IN_PROGRAMS | MCV_IN_CHECK | MCV_IN_MEASURE | MCV_IN_CAMERA_MODEL | \
          MCV_IN_DETECT, \
      NULL, 0, 0, "use only this sensor, by name or number") \
    X(count, spp, "spp", 0, "N", MCV_IN_PATHS | MCV_IN_SCAN, NULL, 1, 1ull << 37, \
      "stop at N samples per pixel over all replicates; N / replicates is rounded up to a " \
      "power of two") \
    X(number, error, "error", 0, "E", MCV_IN_PATHS, NULL, 0, 1e9, \
      "stop at this error: root of the mean squared standard error over the image's mean; " \
      "without --spp, --error, --time and --samples the limits are 0.01 and 60 s") \
    X(time, time, "time", 0, "T", MCV_IN_PATHS, NULL, 0, 1e9, \
      "stop between 0.8 T and T seconds (or with a unit: 5min), building the scene and the " \
      "kernels included; earlier where one more sample of each pixel and replicate (8 with " \
      "adaptive sampling) would pass T; the first one is always rendered") \
    X(range, samples, "samples", 0, "A:B", MCV_IN_RENDER, NULL, 0, 1ull << 31, \
      "render only samples A to B - 1 of each replicate; B - A is a power of two and A a " \
      "multiple of it") \
    X(count, replicates, "replicates", 0, "R", MCV_IN_RENDERS | MCV_IN_MATRICES | MCV_IN_SCAN, \
      "4", 1, 64, \
      "number of independent scrambles of the sample points; their spread gives the standard " \
      "error") \
    X(count, repeats, "replicates", 0, "R", MCV_IN_COMPARE, "16", 2, 64, \
      "number of independent scrambles of a scene's sample points; their spread is the noise " \
      "that a difference must exceed") \
    X(text, against, "against", 0, "OPTIONS", MCV_IN_COMPARE, NULL, 0, 0, \
      "options of the scene B that differ from those of A, in quotes, as in " \
      "--against=\"--device reference --depth 64\"; if its seed would equal A's, the next one " \
      "is used") \
    X(choice, adaptive, "adaptive", 0, "auto|on|off", MCV_IN_RENDER, "auto", 0, 0, \
      "give noisier pixels more samples, and the others fewer: on: if a pilot says that it " \
      "takes fewer samples; auto: if it wins even where noisy pixels take longer; --spp then " \
      "limits the mean; the part `samples` of the OpenEXR file has the number of each pixel; " \
      "auto is off with --samples, for the reference renderer, and for sensors of directions, " \
      "as light field cameras") \
    X(choice, sampler, "sampler", 0, "sobol|random", MCV_IN_PROGRAMS, "sobol", 0, 0, \
      "Owen-scrambled Sobol' points, or independent random points") \
    X(choice, split, "split", 0, "on|off", MCV_IN_PROGRAMS, "on", 0, 0, \
      "on: at glass, sheets and beam splitters follow both the reflected and the transmitted " \
      "path; off: follow one of them at random") \
    X(choice, light_paths, "light-paths", 0, "auto|on|off", MCV_IN_PROGRAMS, "auto", 0, 0, \
      "light paths from emitters: auto: `render` measures how many are worth their time, or that " \
      "none are, other commands trace as many as `on` does; on: as many as the scene's geometry " \
      "suggests; off: none, then caustics of lights without extent are missing") \
    X(count, seed, "seed", 0, "S", \
      MCV_IN_GREY | MCV_IN_COMPARE | MCV_IN_MATRICES | MCV_IN_EXPLAIN, "0", 0, UINT32_MAX, \
      "seed of the noise; the same seed gives the same bits; with one seed, the images of a " \
      "sequence have the same noise; pictures of render have it only with --adaptive off, " \
      "because each picks its samples otherwise") \
    X(count, depth, "depth", 0, "N", MCV_IN_EXPLAIN | MCV_IN_PATHS | MCV_IN_TRACE | MCV_IN_SCAN, \
      "32", 1, 1000000, "largest number of surfaces on a path") \
    X(size, resolution, "resolution", 0, "WxH", \
      MCV_IN_EXPLAIN | MCV_IN_PATHS | MCV_IN_CAMERA_MODEL, NULL, 1, 65536, \
      "other number of pixels on the same field of view; macro pixels for a light field " \
      "camera") \
    X(choice, schedule, "schedule", 0, "auto|tile|stream", MCV_IN_PROGRAMS, "auto", 0, 0, \
      "how the stages are launched: tile, a slice of the image at a time (CPUs); stream, one " \
      "launch per stage (GPUs); both give the same bits") \
    X(text, device, "device", 0, "D", MCV_IN_PROGRAMS | MCV_IN_TRACE, NULL, 0, 0, \
      "a number from `mcvisi devices`, PLATFORM:TYPE:NAME, or several as in 0,1, which share " \
      "the image; or `reference`: the independent renderer in double precision, slow") \
    X(choice, precision, "precision", 0, "single|mixed|double", MCV_IN_PROGRAMS | MCV_IN_TRACE, \
      NULL, 0, 0, \
      "single: float32, the default; mixed: hits on smooth surfaces and directions behind " \
      "them in double; double: all in double, by the reference renderer, slow") \
    X(count, threads, "threads", 0, "N", MCV_IN_PROGRAMS | MCV_IN_TRACE | MCV_IN_LIGHTFIELD, NULL, \
      1, 1024, \
      "threads of the host, for building the scene, the reference renderer and the gradient; " \
      "by default one per core") \
    X(text, rays, "rays", 0, "rays.csv", MCV_IN_TRACE, NULL, 0, 0, \
      "the rays: rows x,y,z,dx,dy,dz in metres, in world coordinates") \
    X(text, paths, "output", 'o', "paths.csv", MCV_IN_TRACE, NULL, 0, 0, \
      "the file of the vertices; by default standard output") \
    X(text, difference, "output", 'o', "DIFF.png", MCV_IN_COMPARE, NULL, 0, 0, \
      "a PNG of the differences A - B in units of their standard error") \
    X(text, grey, "output", 'o', "FILE", MCV_IN_CAMERA, NULL, 0, 0, \
      "the grey values [DN], unscaled: .png, .tif or .npy, with 8 bits for --bits up to 8, " \
      "else 16, and FILE-preview.png to look at; .exr with the whole header of the image and " \
      "the standard uncertainty of each value") \
    X(text, model, "output", 'o', "FILE|RIG.gltf", MCV_IN_CAMERA_MODEL, NULL, 0, 0, \
      "the file of the model, by default standard output; COLMAP's folder; with --import the " \
      "rig, which is made where there is none") \
    X(choice, format, "format", 0, "json|opencv|ros|halcon|colmap", MCV_IN_CAMERA_MODEL, "json", \
      0, 0, "the program that reads the model; json: that of the headers of images") \
    X(text, import, "import", 0, "FILE", MCV_IN_CAMERA_MODEL, NULL, 0, 0, \
      "add the camera of this file, in any of the formats, with its pose to the rig of " \
      "--output; --sensor is then the name of the new sensor") \
    X(text, camera, "camera", 0, "FILE", MCV_IN_RENDER, NULL, 0, 0, \
      "also write the grey values of a camera, as `mcvisi camera` does from the image; its " \
      "options apply") \
    MCV_CAMERA_OPTIONS(X) \
    X(list, region, "region", 0, "[NAME=]X,Y,W,H", MCV_IN_FIGURES, NULL, 0, 0, \
      "region to measure, in pixels from the top-left corner: a rectangle, a polygon " \
      "X,Y,X,Y,X,Y,… or an image F.png, whose pixels above 0 belong to it; or a rectangle on " \
      "the part, see --edge; may be repeated; by default the whole image") \
    X(text, background, "background", 0, "REGION", MCV_IN_FIGURES, NULL, 0, 0, \
      "region to compare the others with: gives Weber and Michelson contrast and the " \
      "contrast-to-noise ratio") \
    X(list, edge, "edge", 0, "[NAME=]X,Y,W,H", MCV_IN_FIGURES, NULL, 0, 0, \
      "a rectangle with one straight edge in it: gives its position, tilt, 10-90 % width, " \
      "sagitta and, if it is tilted, the modulation transfer function (ISO 12233); a curved " \
      "edge is an error; may be repeated: gives the distances from the first. In all boxes, " \
      "@NODE:X,Y,Z,W,H replaces X,Y,W,H by a rectangle W wide and H high in the image about a " \
      "point in the node's coordinates, all lengths with units, as in " \
      "left=@part:-20mm,0mm,3mm,2mm,4mm") \
    X(list, line, "line", 0, "[NAME=]X,Y,W,H[+X,Y,W,H…]", MCV_IN_FIGURES, NULL, 0, 0, \
      "rectangles, joined by +, that one straight edge passes: gives the position, tilt and " \
      "straightness (root mean square) of one line through them, and distances from the first " \
      "edge or line; may be repeated") \
    X(list, caliper, "caliper", 0, "[NAME=]X,Y,W,H", MCV_IN_FIGURES, NULL, 0, 0, \
      "a rectangle whose longer side crosses two opposite edges: gives their distance and " \
      "angle; may be repeated") \
    X(list, circle, "circle", 0, "[NAME=]X,Y,W,H", MCV_IN_FIGURES, NULL, 0, 0, \
      "a rectangle around a circle, some pixels larger: gives its centre (column, row), " \
      "radius, diameter and roundness (root mean square); may be repeated: gives the " \
      "distances of the centres from the first, and from the first edge or line") \
    X(list, arc, "arc", 0, "[NAME=]X,Y,W,H", MCV_IN_FIGURES, NULL, 0, 0, \
      "a rectangle around a part of a circle: gives what --circle gives; may be repeated") \
    X(text, minus, "minus", 0, "OTHER", MCV_IN_MEASURE, NULL, 0, 0, \
      "measure in the difference IMAGE - OTHER") \
    X(choice, channel, "channel", 0, "mean|red|green|blue", MCV_IN_FIGURES, "mean", 0, 0, \
      "channel of a colour image") \
    X(number, noise, "noise", 0, "S", MCV_IN_MEASURE, NULL, 0, 1e30, \
      "standard uncertainty of each value, for images that do not state it; or give --gain " \
      "with --read-noise and --black-level; by default it is estimated from the differences " \
      "of neighbouring pixels") \
    X(text, scene, "scene", 0, "SCENE", MCV_IN_MEASURE, NULL, 0, 0, \
      "the scene of an image whose header does not give the scale; lengths are in its plane " \
      "in focus") \
    X(flag, nominal, "nominal", 0, NULL, MCV_IN_MEASURE, NULL, 0, 0, \
      "with --scene: subtract the growth of a thick part's edges before a backlight, as " \
      "`mcvisi check` states it, and add its uncertainty; for telecentric cameras only") \
    X(text, grid, "grid", 0, "[NODE=]F.png", MCV_IN_MEASURE, NULL, 0, 0, \
      "draw the image with pixel coordinates, the node's coordinates in the plane in focus in " \
      "millimetres, and the given places; by default the first node that the header names") \
    MCV_EXPERIMENT_OPTIONS(X) \
    MCV_LIGHTFIELD_OPTIONS(X) \
    MCV_EXEC_OPTIONS(X) \
    MCV_POD_OPTIONS(X) \
    MCV_TRANSPORT_OPTIONS(X) \
    MCV_TRIANGULATE_OPTIONS(X) \
    MCV_SCAN_OPTIONS(X) \
    MCV_DEFLECTION_OPTIONS(X) \
    MCV_INVERSE_OPTIONS(X) \
    MCV_DEFECT_OPTIONS(X) \
    MCV_DEFLECTOMETRY_OPTIONS(X) \
    MCV_DETECT_OPTIONS(X) \
    X(list, set, "set", 0, "PATH=VALUE", MCV_IN_SCENES | MCV_IN_RELIGHT | MCV_IN_DETECT, NULL, 0, \
      0, \
      "change the scene, as in --set sensors/cam/fNumber=8 or --set " \
      "emitters/back/halfAngle=0.2deg; may be repeated") \
    X(bytes, memory, "memory", 0, "SIZE", MCV_IN_SCENES, NULL, 0, 1e18, \
      "refuse scenes whose files, images and triangles take more memory: bytes, or as in 500MB " \
      "(kB, MB, GB); by default half of the machine's; check prints what a scene takes") \
    X(text, html, "html", 0, "F.html", MCV_IN_CHECK, NULL, 0, 0, \
      "also draw the set-up: a page with each sensor's view from the side and from above, " \
      "with rays, field, focus, depth of field, lights and dimensions, and the findings") \
    X(flag, strict, "strict", 0, NULL, MCV_IN_CHECK, NULL, 0, 0, \
      "check the glTF file alone and whole, as Khronos' validator does; exit code 3 if it errs") \
    X(flag, defines, "defines", 0, NULL, MCV_IN_CHECK, NULL, 0, 0, \
      "print the -D options of the scene's OpenCL programs; without a scene, of all features") \
    X(flag, json, "json", 0, NULL, \
      MCV_IN_RENDERS | MCV_IN_MERGE | MCV_IN_NEW | MCV_IN_CHECK | MCV_IN_COMPARE | MCV_IN_CAMERA | \
          MCV_IN_CAMERA_MODEL | MCV_IN_MEASURE | MCV_IN_POD | MCV_IN_LIGHTFIELD | MCV_IN_IMPORT | \
          MCV_IN_DEVICES | MCV_IN_HELP | MCV_IN_DEFECT | MCV_IN_DETECT | MCV_IN_MATRICES | \
          MCV_IN_TRIANGULATE | MCV_IN_SCAN | MCV_IN_RELIGHT | MCV_IN_INVERSE | MCV_IN_EXPLAIN | \
          MCV_IN_WARM, \
      NULL, 0, 0, \
      "print JSON in SI units; render prints one object per sensor, each on one line; help " \
      "prints a schema of the options")

#endif
