# SPDX-License-Identifier: Apache-2.0
"""blender_peer.py FOLDER: a part as Blender exports it, with its defaults but for the format:
part.glb, part.gltf, binary and ASCII STL; and lit.glb, with the camera and the light that the
defaults leave out.

The part is a plate of 40 mm x 30 mm x 12 mm (x, y, z; z is up in Blender) with a tab of 10 mm x
10 mm x 12 mm at its +x side, a copy that is turned by 90 degrees about z and hangs on an empty. The
scene is Blender's own beginning, with its camera and its light of 1000 W.
"""

import math
import os
import sys

import bpy

bpy.ops.wm.read_factory_settings()
plate = bpy.data.objects["Cube"]  # 2 m wide
plate.scale = (0.020, 0.015, 0.006)
plate.location = (0.1, -0.05, 0.03)

bpy.ops.object.empty_add(location=(0.1, 0, 0))
empty = bpy.context.object
tab = plate.copy()  # Cube.001, of the same mesh
bpy.context.collection.objects.link(tab)
tab.parent = empty
tab.scale = (0.005, 0.005, 0.006)
tab.rotation_euler = (0, 0, math.pi / 2)
tab.location = (0.025, -0.05, 0.03)
bpy.context.view_layer.update()

os.chdir(sys.argv[1])
folder = os.getcwd()
bpy.ops.export_scene.gltf(filepath=folder + "/part.glb")
bpy.ops.export_scene.gltf(filepath=folder + "/part.gltf", export_format="GLTF_SEPARATE")
bpy.ops.export_scene.gltf(filepath=folder + "/lit.glb", export_cameras=True, export_lights=True)
bpy.ops.wm.stl_export(filepath=folder + "/part.stl")
bpy.ops.wm.stl_export(filepath=folder + "/ascii.stl", ascii_format=True)

# All is written; Blender's own end as a module may crash.
sys.stdout.flush()
os._exit(0)
