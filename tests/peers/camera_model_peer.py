# SPDX-License-Identifier: Apache-2.0
"""OpenCV and the camera model: camera_model_peer.py balls|boards PROGRAM

balls   renders small balls and finds the middles of their images; cv2.projectPoints with the model
        that `mcvisi camera-model --format opencv` writes must put them there, within 0.02 pixels.
boards  renders 20 boards; cv2.calibrateCamera must find K within 3 of its own standard deviations.

Prints the largest deviation of each camera. The exit code says whether all is as it must be.
"""

import json
import pathlib
import subprocess
import sys

import cv2
import numpy as np

READOUT = {
    "resolution": [400, 320], "pixelSize": ["5um", "4um"], "regionOfInterest": [50, 40, 320, 240],
    "binning": [2, 2], "principalPoint": [233.3, 141.9],
}
PLAIN = {"resolution": [200, 150], "pixelSize": "10um"}
# A ball's radius over its distance: its image is an ellipse about a point that lies farther out,
# by tan(angle) f (r/z)^2 = 0.003 pixels at most here. Telecentric: its radius in metres.
CAMERAS = {
    "pinhole": ({"type": "pinhole", "imageDistance": "10mm", **PLAIN}, 0.004),
    "pinhole, read out": ({"type": "pinhole", "imageDistance": "10mm", **READOUT}, 0.004),
    "thin lens, read out": (
        {"type": "thinLens", "focalLength": "10mm", "focusDistance": "500mm", "fNumber": 8,
         **READOUT}, 0.004),
    "telecentric, read out": (
        {"type": "telecentric", "magnification": 0.25, "workingDistance": "500mm", "fNumber": 16,
         **READOUT}, 150e-6),
}
# From the world to the camera: any that is not simple.
TURN, PLACE = np.array([0.3, -0.5, 0.1, 0.8062257748298549]), np.array([0.05, -0.2, 0.3])
numbers = np.random.default_rng(3)
program = pathlib.Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else None


def run(*line):
    subprocess.run([program, *map(str, line)], check=True, stdout=subprocess.DEVNULL)


def matrix(q):
    """The rotation of x, y, z, w."""
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def write_rig(path, sensor, places, radii):
    """Black balls before a sky that is equally bright everywhere."""
    nodes = [
        {"name": "camera", "translation": list(PLACE), "rotation": list(TURN),
         "extensions": {"MCVISI_sensors": {"sensor": 0}}},
        {"name": "sky", "extensions": {"MCVISI_emitters": {"emitter": 0}}},
    ]
    surfaces = []
    for i, (place, radius) in enumerate(zip(places, radii)):
        surfaces.append({"name": "b%d" % i, "type": "sphere", "radius": radius, "material": "black"})
        nodes.append({"name": "b%d" % i, "translation": list(place),
                      "extensions": {"MCVISI_surfaces": {"surface": i}}})
    names = ["MCVISI_emitters", "MCVISI_materials", "MCVISI_sensors", "MCVISI_surfaces"]
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}],
        "extensionsUsed": names, "nodes": nodes,
        "materials": [{"name": "black", "extensions": {"MCVISI_materials": {"type": "absorber"}}}],
        "extensions": {
            "MCVISI_sensors": {"sensors": [{"name": "camera", **sensor}]},
            "MCVISI_surfaces": {"surfaces": surfaces},
            "MCVISI_emitters": {"emitters": [
                {"name": "sky", "type": "environment", "radiance": 1}]},
        },
    }))


def read_model(path):
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert file.isOpened(), path
    return {name: file.getNode(name).mat() for name in
            ("camera_matrix", "distortion_coefficients", "rvec", "tvec", "projection_matrix")}


def project(model, points):
    """Columns and rows as OpenCV counts them: the centre of the first pixel is (0, 0)."""
    if model["camera_matrix"] is None:
        seen = model["projection_matrix"] @ np.c_[points, np.ones(len(points))].T
        return (seen[:2] / seen[2]).T
    return cv2.projectPoints(points, model["rvec"], model["tvec"], model["camera_matrix"],
                             model["distortion_coefficients"])[0][:, 0]


def middle(image, near, half):
    """The middle of what is dark about a place."""
    column, row = np.round(near).astype(int)
    rows, columns = np.mgrid[row - half:row + half + 1, column - half:column + half + 1]
    dark = 1 - image[rows, columns] / 50000.0
    return np.array([(dark * columns).sum(), (dark * rows).sum()]) / dark.sum()


def look_at_balls(name, sensor, size):
    telecentric = sensor["type"] == "telecentric"
    field = 2.5e-3 if telecentric else 0.05  # some half of it: in m, or a tangent
    turn = matrix(TURN)
    # In the sensor's axes: x right, y up, looking along -z.
    grid = np.array([[x, y] for x in np.linspace(-0.7, 0.7, 4) for y in np.linspace(-0.45, 0.5, 3)])
    grid = grid + numbers.uniform(-0.05, 0.05, grid.shape)
    depth = numbers.uniform(0.498, 0.502, 12) if telecentric else numbers.uniform(0.45, 0.55, 12)
    across = grid * field * (1 if telecentric else depth[:, None])
    places = np.c_[across, -depth] @ turn.T + PLACE
    radii = np.full(12, size) if telecentric else size * depth
    rig = pathlib.Path("balls.gltf")
    write_rig(rig, sensor, places, radii)
    run("camera-model", rig, "--format", "opencv", "-o", "balls.yml")
    run("render", rig, "--spp", 1024, "-o", "balls.exr", "--camera", "balls.npy", "--bits", 16,
        "--electrons-per-unit", 50000, "--full-well", 65535, "--noise-free", "--lens-mtf", "none")
    image = np.load("balls.npy").astype(float)
    model = read_model("balls.yml")
    off, seen = [], 0
    for place in project(model, places):
        inside = (place > 9).all() and (place < np.array(image.shape)[::-1] - 10).all()
        if inside:
            seen += 1
            off.append(middle(image, place, 8) - place)
    most = np.abs(off).max() if off else np.inf
    print("%s: %d balls, at most %.4f pixels off" % (name, seen, most))
    return seen >= 6 and most < 0.02


def balls():
    return all([look_at_balls(name, *camera) for name, camera in CAMERAS.items()])


# --- boards ---

COLUMNS, ROWS, SIDE = 9, 7, 5e-3  # squares, and their side


def write_board(path):
    """The dark squares, each of two triangles, in the plane z = 0."""
    triangles = []
    for i in range(COLUMNS):
        for j in range(ROWS):
            if (i + j) % 2:
                continue
            x, y = (i - COLUMNS / 2) * SIDE, (j - ROWS / 2) * SIDE
            a, b, c, d = (x, y, 0), (x + SIDE, y, 0), (x + SIDE, y + SIDE, 0), (x, y + SIDE, 0)
            triangles += [(a, b, c), (a, c, d)]
    body = b"".join(np.array([(0, 0, 1), *t], "<f4").tobytes() + b"\0\0" for t in triangles)
    path.write_bytes(bytes(80) + np.uint32(len(triangles)).tobytes() + body)


def board_rig(rotation, translation):
    """Black squares 120 mm before a thin lens, in a bright world."""
    sensor = {"name": "camera", "type": "thinLens", "focalLength": "8mm", "focusDistance": "120mm",
              "fNumber": 16, "resolution": [1400, 1100], "pixelSize": "4um",
              "regionOfInterest": [60, 80, 1280, 960], "binning": [2, 2],
              "principalPoint": [731.4, 522.7]}
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "extensionsUsed": [
            "MCVISI_assets", "MCVISI_emitters", "MCVISI_materials", "MCVISI_sensors"],
        "materials": [{"name": "black", "extensions": {"MCVISI_materials": {"type": "absorber"}}}],
        "nodes": [
            {"name": "board", "translation": translation, "rotation": rotation,
             "extensions": {"MCVISI_assets": {"asset": 0}}},
            {"name": "camera", "translation": [0, 0, 0.12],
             "extensions": {"MCVISI_sensors": {"sensor": 0}}},
            {"name": "sky", "extensions": {"MCVISI_emitters": {"emitter": 0}}},
        ],
        "extensions": {
            "MCVISI_sensors": {"sensors": [sensor]},
            "MCVISI_assets": {"assets": [
                {"name": "board", "uri": "board.stl", "unit": "m", "material": "black"}]},
            "MCVISI_emitters": {"emitters": [
                {"name": "sky", "type": "environment", "radiance": 1}]},
        },
    }


def boards():
    write_board(pathlib.Path("board.stl"))
    points = SIDE * np.array(
        [[i, j, 0] for j in range(ROWS - 1) for i in range(COLUMNS - 1)], np.float32)
    found = []
    rig = pathlib.Path("board.gltf")
    for view in range(20):
        axis = numbers.normal(size=3) * [1, 1, 0.3]
        axis /= np.linalg.norm(axis)
        angle = np.radians(numbers.uniform(15, 35))
        rotation = [*(axis * np.sin(angle / 2)), np.cos(angle / 2)]
        place = [*numbers.uniform(-6e-3, 6e-3, 2), numbers.uniform(-12e-3, 12e-3)]
        rig.write_text(json.dumps(board_rig(rotation, place)))
        run("render", rig, "--spp", 16, "--seed", view, "-o", "board.exr", "--camera", "grey.png",
            "--expose-to", 0.6, "--read-noise", 5, "--bits", 8)
        image = cv2.imread("grey.png", cv2.IMREAD_UNCHANGED)
        seen, corners = cv2.findChessboardCornersSB(
            image, (COLUMNS - 1, ROWS - 1), flags=cv2.CALIB_CB_ACCURACY)
        if seen:
            found.append(corners)
    run("camera-model", rig, "--format", "opencv", "-o", "board.yml")
    stated = read_model("board.yml")["camera_matrix"]
    flags = (cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3)
    rms, k, _, _, _, deviation, _, _ = cv2.calibrateCameraExtended(
        [points] * len(found), found, image.shape[::-1], None, None, flags=flags)
    print("%d boards, root mean square %.3f pixels" % (len(found), rms))
    right = len(found) >= 18
    for i, (name, at) in enumerate((("fx", (0, 0)), ("fy", (1, 1)), ("cx", (0, 2)), ("cy", (1, 2)))):
        sigma = float(deviation[i][0])
        print("%s %.3f, the model %.3f: %+.2f standard deviations of %.3f" %
              (name, k[at], stated[at], (k[at] - stated[at]) / sigma, sigma))
        right = right and abs(k[at] - stated[at]) < 3 * sigma
    return right


if __name__ == "__main__":
    sys.exit(0 if {"balls": balls, "boards": boards}[sys.argv[1]]() else 1)
