// Light at vertices that is found in steps: while objects move, and after a first frame with fewer
// rays.
#include <algorithm>
#include <numeric>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>

#include "objects/vertex_light.h"

namespace pleinair {

void VertexLight::BeginFrame(LightSteps steps) {
  steps_ = steps;
  if (is_coarse_ && steps != LightSteps::kFirst) LeaveCoarse();
  if (follows_) responses_[0].done.Invalidate();
}

bool VertexLight::MayStartCoarse() const {
  const GatherInMotionOptions& options = options_.in_motion;
  return steps_ == LightSteps::kFirst && daylight_ == nullptr && options.vertices_per_frame > 0 &&
         options.rays_at_first > 0 && options.rays_at_first < options_.gather.rays_per_receiver &&
         std::all_of(
             world_from_given_.begin(), world_from_given_.end(), &LightInMotion::KeepsShape);
}

void VertexLight::LeaveCoarse() {
  left_ = Left{std::nullopt,
               std::exchange(gather_, ObjectGather()),
               world_from_given_,
               responses_[0].of_light,
               responses_[0].done};
  near_sunlight_.reset();
  has_object_moved_.assign(world_from_given_.size(), true);
  follows_ = true;
  is_coarse_ = false;
}

bool VertexLight::Leave(const std::vector<glm::dmat4>& world_from_given) {
  const std::vector<glm::dmat4> stood = std::exchange(world_from_given_, world_from_given);
  const bool keep_shape =
      std::all_of(world_from_given.begin(), world_from_given.end(), &LightInMotion::KeepsShape);
  const bool has_gathered = gather_.VertexCount() > 0 && gather_.IsComplete();
  if (steps_ != LightSteps::kMoving || !IsGathered() || daylight_ != nullptr ||
      options_.in_motion.vertices_per_frame == 0 || !keep_shape ||
      stood.size() != world_from_given.size() || (!follows_ && !has_gathered)) {
    left_.reset();
    motion_ = LightInMotion(scene_);
    return false;
  }
  has_object_moved_.resize(stood.size());
  for (std::size_t object = 0; object < stood.size(); ++object) {
    has_object_moved_[object] = stood[object] != world_from_given[object];
  }
  if (has_gathered) {
    left_ = Left{std::move(interreflection_),
                 std::move(gather_),
                 stood,
                 responses_[0].of_light,
                 responses_[0].done};
  }
  return true;
}

std::vector<std::size_t> VertexLight::NextParts() {
  constexpr std::size_t kPart = ObjectGather::kVerticesPerPart;
  const std::size_t all = gather_.PartCount();
  // Parts that lack rays, from `first` on and then from the beginning.
  const auto lacking = [&](bool of_moved, std::size_t first) {
    std::vector<std::size_t> parts;
    for (std::size_t i = 0; i < all; ++i) {
      const std::size_t part = (first + i) % all;
      if (!gather_.HasCast(part) && part_moves_[part] == of_moved) parts.push_back(part);
    }
    return parts;
  };
  std::vector<std::size_t> parts = lacking(true, next_moved_part_);
  std::vector<std::size_t> others = lacking(false, next_other_part_);
  const bool moves = steps_ == LightSteps::kMoving;
  const GatherInMotionOptions& options = options_.in_motion;
  const int vertices = moves ? options.vertices_per_frame : options.vertices_at_rest;
  const std::size_t most = vertices == 0 || steps_ == LightSteps::kAll
                               ? all
                               : (static_cast<std::size_t>(vertices) + kPart - 1) / kPart;
  // Light at resting objects changes only by those that move.
  const std::size_t for_others = moves && most > 1 ? std::max<std::size_t>(most / 4, 1) : 0;
  parts.resize(std::min(parts.size(), most - std::min(others.size(), for_others)));
  others.resize(std::min(others.size(), most - parts.size()));
  if (!parts.empty()) next_moved_part_ = parts.back() + 1;
  if (!others.empty()) next_other_part_ = others.back() + 1;
  parts.insert(parts.end(), others.begin(), others.end());
  return parts;
}

bool VertexLight::Follow(const FrameBasis& basis, std::span<const std::size_t> lights) {
  const PatchScene& objects = interreflection_.Objects();
  if (gather_.VertexCount() == 0) {
    gather_ = ObjectGather::InParts(objects, scene_.patches, options_.gather);
    near_of_part_.assign(gather_.PartCount(), std::nullopt);
    part_moves_.assign(gather_.PartCount(), false);
    std::size_t vertex = 0;
    for (std::size_t object = 0; object < objects_->size(); ++object) {
      const std::size_t end = vertex + (*objects_)[object].mesh.positions_m.size();
      for (; vertex < end; ++vertex) {
        if (has_object_moved_[object]) part_moves_[vertex / ObjectGather::kVerticesPerPart] = true;
      }
    }
  }
  std::vector<std::size_t> parts = NextParts();
  if (!left_ && motion_order_ != basis.OrderId()) {
    // The known light is of other lights.
    parts.resize(gather_.PartCount());
    std::iota(parts.begin(), parts.end(), std::size_t{0});
  }
  gather_.Cast(objects, scene_.patches, parts);
  if (lights.front() == 0 && scene_.options.bounces != 0) {
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
      NearSunlightOptions options;
      options.first_receiver = gather_.VerticesOf(parts[i]).begin * ObjectGather::kPointsPerVertex;
      near_of_part_[parts[i]].emplace(scene_.patches, objects, gather_.PointsOf(parts[i]), options);
    });
  }
  if (gather_.IsComplete()) {
    const bool all_near = std::all_of(near_of_part_.begin(),
                                      near_of_part_.end(),
                                      [](const auto& near) { return near.has_value(); });
    if (all_near) {
      near_sunlight_.emplace();
      for (const auto& near : near_of_part_) near_sunlight_->Append(*near);
    }
    near_of_part_.clear();
    SmoothThisShape();
    left_.reset();
    follows_ = false;
    return false;
  }
  if (left_) {
    // In another set of skies a light's index means another light.
    for (std::size_t light = 0; light < left_->irradiance.size(); ++light) {
      if (!left_->done.Ever(basis, light)) left_->irradiance[light].clear();
    }
    const std::optional<ObjectInterreflection>& stood = left_->interreflection;
    motion_.Start({stood ? *stood : interreflection_, left_->world_from_given},
                  left_->gather,
                  left_->irradiance,
                  {basis, lights});
    motion_order_ = basis.OrderId();
    left_.reset();
  }
  motion_.Update({interreflection_, world_from_given_},
                 gather_,
                 GatherParts(parts, basis, lights),
                 {basis, lights},
                 responses_[0].of_light);
  for (const std::size_t light : lights) Smooth(light);
  return true;
}

std::vector<LightInMotion::Gathered> VertexLight::GatherParts(std::span<const std::size_t> parts,
                                                              const FrameBasis& basis,
                                                              std::span<const std::size_t> lights) {
  const PatchScene& objects = interreflection_.Objects();
  std::vector<LightInMotion::Gathered> gathered(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    gathered[i] = {parts[i], VerticesByLight(lights.size())};
  }
  for (std::size_t i = 0; i < lights.size(); ++i) {
    std::vector<glm::vec3> radiosity(objects.FaceCount(), glm::vec3(0.0f));
    const std::vector<glm::vec3>& of_real = basis.FaceRadiosity(lights[i]);
    radiosity.insert(radiosity.end(), of_real.begin(), of_real.end());
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
      std::vector<glm::vec3>& irradiance = gathered[p].irradiance[i];
      irradiance = gather_.IrradianceOf(parts[p], basis.Sky(lights[i]), radiosity);
      const std::optional<NearSunlight>& near = near_of_part_[parts[p]];
      if (lights[i] != 0 || !near) return;
      const std::vector<glm::vec3> change = gather_.AtVerticesOf(
          parts[p],
          near->Change(scene_.patches, objects, basis.BounceSun(), basis.DirectIrradiance()));
      for (std::size_t v = 0; v < irradiance.size(); ++v) {
        irradiance[v] = glm::max(irradiance[v] + change[v], glm::vec3(0.0f));
      }
    });
  }
  return gathered;
}

}  // namespace pleinair
