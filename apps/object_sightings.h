// Where virtual objects are that no frame of a run shows.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "objects/virtual_object.h"
#include "render/compositor.h"
#include "scene/camera.h"

namespace pleinair {

class ObjectSightings {
 public:
  // A frame's picture, and its camera.
  void Add(const Camera& camera, const Composite& composite);

  // None where some frame shows part of an object, and without frames or objects. Else the note
  // says where `objects`, in world coordinates as in the first frame, are for the first camera.
  std::optional<std::string> Note(const std::vector<VirtualObject>& objects) const;

 private:
  std::optional<Camera> first_camera_;
  bool is_any_seen_ = false;
};

}  // namespace pleinair
