#include "render/internal/scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "render/internal/view_projection.h"

namespace pleinair {
namespace {

[[noreturn]] void Refuse(const std::string& mesh, const std::string& what) {
  throw std::invalid_argument(mesh + ": " + what);
}

void ValidateGeometry(const Mesh& mesh, const std::string& name) {
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    const glm::vec3& position = mesh.positions_m[i];
    if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z)) {
      Refuse(name, "positions_m[" + std::to_string(i) + "] is not finite");
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.triangles[i][corner] >= mesh.positions_m.size()) {
        Refuse(name,
               "triangles[" + std::to_string(i) + "] has vertex " +
                   std::to_string(mesh.triangles[i][corner]) + ", expected below " +
                   std::to_string(mesh.positions_m.size()));
      }
    }
  }
}

void ValidateShading(const Mesh& mesh, const std::string& name) {
  if (mesh.normals.size() != mesh.positions_m.size()) {
    Refuse(name,
           "normals has " + std::to_string(mesh.normals.size()) + " entries, expected " +
               std::to_string(mesh.positions_m.size()) + ", one a vertex");
  }
  if (mesh.materials.empty()) return;
  if (mesh.triangle_material.size() != mesh.triangles.size()) {
    Refuse(name,
           "triangle_material has " + std::to_string(mesh.triangle_material.size()) +
               " entries, expected " + std::to_string(mesh.triangles.size()) + ", one a triangle");
  }
  for (std::size_t i = 0; i < mesh.triangle_material.size(); ++i) {
    if (mesh.triangle_material[i] >= mesh.materials.size()) {
      Refuse(name,
             "triangle_material[" + std::to_string(i) + "] is " +
                 std::to_string(mesh.triangle_material[i]) + ", expected below " +
                 std::to_string(mesh.materials.size()));
    }
  }
}

void ValidateColours(const Mesh& mesh, const std::string& name) {
  const bool is_by_place =
      std::any_of(mesh.materials.begin(), mesh.materials.end(), [](const Material& material) {
        return material.by_place != nullptr;
      });
  if (mesh.triangle_colours.size() != mesh.triangles.size() &&
      (is_by_place || !mesh.triangle_colours.empty())) {
    Refuse(name,
           "triangle_colours has " + std::to_string(mesh.triangle_colours.size()) +
               " entries, expected " + std::to_string(mesh.triangles.size()) + ", one a triangle");
  }
  for (std::size_t i = 0; i < mesh.triangle_colours.size(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const glm::vec2& uv = mesh.triangle_colours[i].texture_uv[corner];
      const glm::vec4& colour = mesh.triangle_colours[i].vertex_colour[corner];
      constexpr float kMost = 1e6f;  // Coordinates beyond it have hardly a fraction left.
      for (const float value : {uv.x, uv.y, colour.r, colour.g, colour.b, colour.a}) {
        if (std::abs(value) <= kMost) continue;
        Refuse(name,
               "triangle_colours[" + std::to_string(i) + "] holds " + std::to_string(value) +
                   ", expected numbers of at most a million");
      }
    }
  }
}

std::optional<BoundingBox> BoxOf(const ShadowCaster& caster) {
  if (caster.Triangles().empty()) return std::nullopt;
  BoundingBox box{caster.Positions()[0], caster.Positions()[0]};
  for (const glm::vec3& position : caster.Positions()) {
    box.lower_m = glm::min(box.lower_m, position);
    box.upper_m = glm::max(box.upper_m, position);
  }
  return box;
}

}  // namespace

std::vector<glm::vec3> SceneGeometry::LocalFromWorld(
    std::span<const glm::vec3> positions_world) const {
  std::vector<glm::vec3> local;
  local.reserve(positions_world.size());
  for (const glm::vec3& position : positions_world) {
    local.emplace_back(glm::dvec3(position) - origin_world_m_);
  }
  return local;
}

void SceneGeometry::SetPhantom(const Mesh& mesh_world) {
  ValidateGeometry(mesh_world, "phantom mesh");
  has_phantom_origin_ = !mesh_world.Empty();
  if (has_phantom_origin_) {
    const BoundingBox box = BoundingBoxOf(mesh_world);
    origin_world_m_ = 0.5 * (glm::dvec3(box.lower_m) + glm::dvec3(box.upper_m));
  }
  phantom_ = ShadowCaster(LocalFromWorld(mesh_world.positions_m), mesh_world.triangles);
  phantom_box_ = BoxOf(phantom_);
  phantom_buffers_.UploadSurface(phantom_);
  RebuildObjects();
}

void SceneGeometry::SetObjects(std::vector<VirtualObject> objects) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::string name = "objects[" + std::to_string(i) + "].mesh";
    ValidateGeometry(objects[i].mesh, name);
    ValidateShading(objects[i].mesh, name);
    ValidateColours(objects[i].mesh, name);
  }
  objects_ = std::move(objects);
  RebuildObjects();
}

void SceneGeometry::RebuildObjects() {
  if (!has_phantom_origin_) {
    origin_world_m_ = glm::dvec3(0.0);
    for (const VirtualObject& object : objects_) {
      if (object.mesh.Empty()) continue;
      const BoundingBox box = BoundingBoxOf(object.mesh);
      origin_world_m_ = 0.5 * (glm::dvec3(box.lower_m) + glm::dvec3(box.upper_m));
      break;
    }
  }
  std::vector<const Mesh*> meshes;
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (const VirtualObject& object : objects_) {
    meshes.push_back(&object.mesh);
    const auto first_vertex = static_cast<std::uint32_t>(positions.size());
    const std::vector<glm::vec3> local = LocalFromWorld(object.mesh.positions_m);
    positions.insert(positions.end(), local.begin(), local.end());
    for (const glm::uvec3& triangle : object.mesh.triangles) {
      triangles.push_back(triangle + first_vertex);
    }
  }
  objects_caster_ = ShadowCaster(positions, triangles);
  object_box_ = BoxOf(objects_caster_);
  object_buffers_.UploadSurface(objects_caster_);
  shaded_objects_.Upload(meshes, positions);
  id_ = StateId::Next();
}

glm::dmat4 SceneGeometry::CameraFromLocal(const Camera& camera) const {
  return glm::translate(camera.camera_from_world, origin_world_m_);
}

LayerView MakeLayerView(const SceneGeometry& scene,
                        const Camera& camera,
                        const CameraIntrinsics& undistorted) {
  LayerView view;
  view.intrinsics = undistorted;
  view.camera_from_local = scene.CameraFromLocal(camera);
  const double real_m =
      scene.PhantomBuffers().Surface().NearestInViewM(undistorted, view.camera_from_local);
  const ScreenExtent objects = ExtentOf(scene.ObjectsAsCaster().Positions(),
                                        scene.ObjectsAsCaster().Triangles(),
                                        undistorted,
                                        view.camera_from_local);
  view.object_rect = objects.rect;
  // Depth in the buffer goes as 1 - near/z: the near plane right before the nearest thing in view
  // gives every other depth the most digits. Where something touches the camera, a plane so close
  // that nothing visible (below a thousandth of a pixel's width in front of the eye) is lost.
  constexpr double kJustBefore = 0.99;
  constexpr double kNearestNearPlane_m = 1e-4;
  const double nearest = std::min(real_m, objects.nearest_m);
  const double near_m =
      std::isfinite(nearest) ? std::max(kJustBefore * nearest, kNearestNearPlane_m) : 1.0;
  view.clip_from_local = ClipFromCamera(undistorted, near_m) * view.camera_from_local;
  view.camera_centre_local = glm::vec3(glm::inverse(view.camera_from_local)[3]);
  return view;
}

}  // namespace pleinair
