"""A walk through a courtyard with a moving object and passing clouds, for make_sequence.py.

A scene module: runs inside Blender, which scripts/make-walk-sequences starts. Each sequence is the
yard of courtyard-clouds seen by a camera that walks, with the statue pushed across the yard. What
differs is how hard the walk is to follow:

  walk-slow       0.5 m/s, a steady hand, poses without error
  walk-handheld   1.2 m/s; the hand shakes: steps, sway and tremor
  walk-blurred    the first half of that path; 1/30 s of exposure, and poses with noise

The statue moves by the animation of object.gltf; truth.json has its pose in each frame, and the
camera's true one. glTF gives its material a reflectance of 0.04 that the rendered statue lacks.
"""

import base64
import datetime
import json
import math
import os

import bpy
import numpy as np
from mathutils import Matrix

RATE_HZ = 10.0
START = "2005-06-21T07:40:00"  # Low sun: the statue walks into the shadow of the east building.
EXPOSURE_S = 1.0 / 30.0  # Of walk-blurred.
SUB_EXPOSURES = 4        # Its moments that are rendered: half a pixel apart at 240 pixels.
# Poses of walk-blurred: together 0.5 px rms of what stands 5 m away, at 640 pixels (fx 500).
POSE_NOISE_RAD = 0.0005  # About each axis.
POSE_NOISE_M = 0.0025    # Along each axis.

VARIANTS = {
    "walk-slow": dict(frames=24, speed_m_s=0.5, shake=0.0, blurred=False, seed=31),
    "walk-handheld": dict(frames=24, speed_m_s=1.2, shake=1.0, blurred=False, seed=32),
    "walk-blurred": dict(frames=12, speed_m_s=1.2, shake=1.0, blurred=True, seed=32),
}


def shake(time_s, seed):
    """Translation (m) and rotation (rad) of the hand: steps at 1.8 Hz, sway, and tremor of 7 Hz."""
    rng = np.random.default_rng(seed)
    parts = ((0.9, 0.012, 0.006), (1.8, 0.015, 0.004), (3.1, 0.003, 0.002), (7.3, 0.0008, 0.0012))
    moved, turned = np.zeros(3), np.zeros(3)
    for hertz, metres, radians in parts:
        phases = rng.uniform(0.0, 2.0 * math.pi, 6)
        wave = np.sin(2.0 * math.pi * hertz * time_s + phases)
        moved += metres * wave[:3]
        turned += radians * wave[3:]
    return moved, turned


def moved_camera(camera_from_world, moved, turned):
    """The camera after a small motion in its own frame."""
    step = np.array(Matrix.Rotation(turned[0], 4, "X") @ Matrix.Rotation(turned[1], 4, "Y")
                    @ Matrix.Rotation(turned[2], 4, "Z"))
    step[:3, 3] = moved
    return step @ camera_from_world


def sunshine(share):
    """(cloud fraction, visible part of the sun) at a share of the walk: a cloud passes."""
    return (float(np.interp(share, (0.0, 0.5, 1.0), (0.1, 0.6, 0.3))),
            float(np.interp(share, (0.0, 0.3, 0.5, 0.65, 1.0), (1.0, 1.0, 0.15, 0.15, 0.9))))


def time_text(time_s):
    moment = datetime.datetime.fromisoformat(START) + datetime.timedelta(seconds=time_s)
    return moment.isoformat(timespec="milliseconds") + "Z"


def write_gltf(path, m, parts, kd, motion, duration_s):
    """The statue with its motion: straight at one speed, turning at one speed."""
    chunks, views, accessors, meshes, nodes = [], [], [], [], []

    def add(array, kind, component, bounds=False):
        data = array.tobytes()
        views.append(dict(buffer=0, byteOffset=sum(map(len, chunks)), byteLength=len(data)))
        chunks.append(data + b"\0" * (-len(data) % 4))
        accessor = dict(bufferView=len(views) - 1, componentType=component, count=len(array), type=kind)
        if bounds:
            flat = array.reshape(len(array), -1)
            accessor.update(min=flat.min(0).tolist(), max=flat.max(0).tolist())
        accessors.append(accessor)
        return len(accessors) - 1

    def y_up(points):  # +Z up to glTF's +Y up.
        points = np.asarray(points, np.float32)
        return np.ascontiguousarray(np.stack([points[:, 0], points[:, 2], -points[:, 1]], -1))

    for part in parts:
        triangles = np.array([(q[0], q[i], q[i + 1]) for q in part["f"] for i in range(1, len(q) - 1)],
                             np.uint32)
        attributes = dict(POSITION=add(y_up(part["v"]), "VEC3", 5126, True),
                          NORMAL=add(y_up(part["n"]), "VEC3", 5126))
        meshes.append(dict(name=part["name"], primitives=[dict(
            attributes=attributes, indices=add(triangles.reshape(-1), "SCALAR", 5125), material=0)]))
        nodes.append(dict(name=part["name"], mesh=len(meshes) - 1))
    poses = [motion(t) for t in (0.0, duration_s)]
    times = add(np.array([0.0, duration_s], np.float32), "SCALAR", 5126, True)
    moved = add(y_up([p[0] for p in poses]), "VEC3", 5126)
    turned = add(np.array([(0.0, math.sin(p[1] / 2), 0.0, math.cos(p[1] / 2)) for p in poses],
                          np.float32), "VEC4", 5126)
    nodes.append(dict(name="statue", children=list(range(len(nodes)))))
    root = len(nodes) - 1
    binary = b"".join(chunks)
    document = dict(
        asset=dict(version="2.0"), scene=0, scenes=[dict(nodes=[root])], nodes=nodes, meshes=meshes,
        materials=[dict(name="statue", pbrMetallicRoughness=dict(
            baseColorFactor=[*kd, 1.0], metallicFactor=0.0, roughnessFactor=1.0))],
        animations=[dict(
            samplers=[dict(input=times, output=moved), dict(input=times, output=turned)],
            channels=[dict(sampler=0, target=dict(node=root, path="translation")),
                      dict(sampler=1, target=dict(node=root, path="rotation"))])],
        accessors=accessors, bufferViews=views,
        buffers=[dict(byteLength=len(binary), uri="data:application/octet-stream;base64,"
                      + base64.b64encode(binary).decode())])
    with open(path, "w") as f:
        json.dump(document, f)


def run(m, args, seq):
    """Called by make_sequence.py, which `m` is."""
    variant = VARIANTS[args.sequence]
    m.parse_time = lambda text: datetime.datetime.fromisoformat(text.replace("Z", "+00:00"))
    yard = m.load_modules(None)["courtyard-clouds"]()
    turn = -18.0  # Of the yard in the world.
    world_from_yard = np.array(Matrix.Rotation(math.radians(turn), 4, "Z"))
    duration_s = (variant["frames"] - 1) / RATE_HZ

    def in_world(point):
        return (world_from_yard @ np.array([*point, 1.0]))[:3]

    def true_pose(time_s):
        walked = variant["speed_m_s"] * time_s
        eye = np.array([-6.3 + 0.92 * walked, -7.6 + 0.39 * walked, 1.65])
        target = np.array([0.4 + 0.5 * walked, 1.5, 1.3])
        moved, turned = shake(time_s, variant["seed"])
        return moved_camera(m.look_at(in_world(eye), in_world(target)),
                            variant["shake"] * moved, variant["shake"] * turned)

    def statue(time_s):
        """Place in the world, and angle about its axis."""
        return in_world([-1.2 + 0.8 * time_s, -1.4 - 0.1 * time_s, 0.0]), math.radians(
            turn + 35.0 + 20.0 * time_s)

    def world_from_statue(time_s):
        place, angle = statue(time_s)
        return Matrix.Translation(place) @ Matrix.Rotation(angle, 4, "Z")

    noise = np.random.default_rng(variant["seed"] + 1000)
    frames = []
    for i in range(variant["frames"]):
        time_s = i / RATE_HZ
        cloud, sun = sunshine(time_s / duration_s)
        stated = true_pose(time_s)
        if variant["blurred"]:
            stated = moved_camera(stated, POSE_NOISE_M * noise.standard_normal(3),
                                  POSE_NOISE_RAD * noise.standard_normal(3))
        frames.append(dict(time=time_text(time_s), time_s=time_s, cloud=cloud, sun=sun, camera=stated))
    sequence = dict(yard, frames=frames, spp_sky=64)
    sequence["object"] = dict(yard["object"], world_from_object=np.eye(4).tolist())
    moments = SUB_EXPOSURES if variant["blurred"] else 1

    class WalkJob(m.Job):
        def cfw(self, frame):
            return frame["camera"]  # As stated: what sequence.json gets.

        def picture(self, frame, with_object):
            """Mean over the exposure: radiance, coverage, and albedo and materials in its middle."""
            image, coverage = 0.0, 0.0
            self.show_object(with_object)
            for k in range(moments):
                late_s = EXPOSURE_S * ((k + 0.5) / moments - 0.5) if moments > 1 else 0.0
                time_s = frame["time_s"] + late_s
                self.r.camera(self.seq["camera"], true_pose(time_s))
                for part in self.vobs:
                    part.matrix_world = world_from_statue(time_s)
                bpy.context.view_layer.update()
                sky = self.r.render_sky(self.sched.sky(frame))
                direction, irradiance = self.sched.sun(frame)[:2]
                sun = self.r.render_sun(direction, irradiance)
                image = image + np.maximum(
                    sky["A"] * (sky["F"] + sun["F"]) + sky["R"] + sun["R"], 0) / moments
                coverage = coverage + sky["cov"] / moments
                if k == moments // 2:
                    middle = sky
            return image, coverage, middle

        def frames(self):
            for i in self.todo:
                frame = self.seq["frames"][i]
                plain = self.path("frames/%06d.exr" % i)
                with_object = self.path("truth/with_object/%06d.exr" % i)
                if os.path.exists(with_object):
                    continue
                sky = self.sched.sky(frame)
                direction, irradiance, azimuth, elevation = self.sched.sun(frame)
                info = dict(
                    sun_direction_enu=direction.tolist(), sun_azimuth_deg=azimuth,
                    sun_elevation_deg=elevation, sun_irradiance_rgb=irradiance.tolist(),
                    sky_irradiance_rgb=m.horizontal_irradiance(sky.astype(np.float64)).tolist(),
                    cloud_fraction=frame["cloud"], sun_visible_fraction=frame["sun"],
                    camera_from_world=true_pose(frame["time_s"]).tolist(),
                    world_from_object=[list(row) for row in world_from_statue(frame["time_s"])])
                with open(os.path.join(self.work, "info_%06d.json" % i), "w") as f:
                    json.dump(info, f)
                image, _, middle = self.picture(frame, False)
                m.write_exr(self.path("truth/albedo_%06d.exr" % i), middle["A"])
                m.write_png(self.path("truth/material_index_%06d.png" % i),
                            np.rint(middle["mat"]).astype(np.uint8))
                m.write_exr(plain, image)
                image, coverage, _ = self.picture(frame, True)
                m.write_png(self.path("truth/masks/coverage_%06d.png" % i),
                            np.rint(np.clip(coverage, 0, 1) * 255).astype(np.uint8))
                m.write_exr(with_object, image)
                print("FRAME %d of %s done" % (i, self.name), flush=True)

        def finish(self):
            super().finish()
            with open(self.path("sequence.json")) as f:
                document = json.load(f)
            document["virtual_object"] = dict(mesh="object.gltf", world_from_object=np.eye(4).tolist())
            if moments > 1:
                for entry in document["frames"]:
                    entry["exposure_s"] = EXPOSURE_S
            document["note_motion"] = (
                "%g m/s, %g frames a second; %s" % (
                    variant["speed_m_s"], RATE_HZ,
                    "poses with noise of %g rad and %g m an axis" % (POSE_NOISE_RAD, POSE_NOISE_M)
                    if moments > 1 else "poses without error"))
            with open(self.path("sequence.json"), "w") as f:
                json.dump(document, f, indent=1)
            # The animation begins again after its last key, which is a frame after the last one.
            write_gltf(self.path("object.gltf"), m, self.parts, self.seq["object"]["kd"], statue,
                       variant["frames"] / RATE_HZ)
            for name in ("object.obj", "object.mtl"):
                os.remove(self.path(name))

    # The mean over the moments has as many samples as a picture of one moment.
    args.spp = max(1, (args.spp or sequence["spp_sky"]) // moments)
    job = WalkJob(args.sequence, sequence, args)
    job.frames()
    job.environment()
    job.skies()
    job.finish()


SEQUENCES = {name: dict(run=run) for name in VARIANTS}
