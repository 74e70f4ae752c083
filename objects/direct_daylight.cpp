#include "objects/direct_daylight.h"

#include <algorithm>
#include <utility>

#include "relight/daylight/windows.h"

namespace pleinair {
namespace {

std::vector<Receiver> VerticesOf(const Mesh& mesh) {
  std::vector<Receiver> vertices;
  vertices.reserve(mesh.positions_m.size());
  for (std::size_t v = 0; v < mesh.positions_m.size(); ++v) {
    vertices.push_back({mesh.positions_m[v], mesh.normals[v]});
  }
  return vertices;
}

// The middle of each object, from where the real scene alone is looked at.
std::vector<glm::dvec3> MiddlesOf(const Mesh& objects) {
  std::vector<std::vector<glm::vec3>> points_m(objects.group_names.size());
  for (std::size_t i = 0; i < objects.triangles.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      points_m[objects.triangle_group[i]].push_back(
          objects.positions_m[objects.triangles[i][corner]]);
    }
  }
  std::vector<glm::dvec3> middles_m;
  for (const std::vector<glm::vec3>& of_one : points_m) {
    if (!of_one.empty()) middles_m.push_back(BoundingSphereOf(of_one).centre_m);
  }
  return middles_m;
}

std::vector<glm::vec3> UnitTable(const std::shared_ptr<const SkyShape>& shape) {
  Lighting unit;
  unit.sky = {{shape->Name(), glm::dvec3(1.0)}};
  return SkyRadianceTable(unit, std::span(&shape, 1));
}

}  // namespace

void DirectDaylightOptions::Validate() const {
  sampling.Validate();
  shadows.Validate();
  for (const Window& window : windows) window.Validate();
}

DirectDaylight::DirectDaylight(const Mesh& room,
                               const RayCaster& real,
                               const PatchScene& objects,
                               const DirectDaylightOptions& options)
    : real_(real),
      objects_(objects.caster),
      shadow_options_(options.shadows),
      sphere_(BoundingSphereOf(objects.mesh.positions_m)),
      vertices_(VerticesOf(objects.mesh)) {
  options.Validate();
  DaylightSamplingOptions sampling = options.sampling;
  windows_ = options.windows;
  if (sampling.restriction == DaylightRestriction::kWholeSky) {
    note_ = "direct daylight: samples of the entire sky";
  } else {
    const std::vector<glm::dvec3> middles_m = MiddlesOf(objects.mesh);
    std::string origin = windows_.size() == 1 ? std::string("1 window given")
                                              : std::to_string(windows_.size()) + " windows given";
    if (windows_.empty()) {
      const FoundWindows found = FindWindows(room, middles_m);
      windows_ = found.windows;
      origin = found.Summary();
    }
    note_ = "direct daylight: " + origin;
    if (SeesSkyPastWindows(real, windows_, middles_m)) {
      sampling.restriction = DaylightRestriction::kWholeSky;
      note_ += "; objects see sky past them: samples of the entire sky";
    }
  }
  sampler_ = std::make_unique<DaylightSampler>(windows_, sphere_, sampling);
}

glm::vec3 DirectDaylight::LargestIrradiance(const std::shared_ptr<const SkyShape>& shape) {
  if (const auto known = largest_.find(shape); known != largest_.end()) return known->second;
  constexpr std::size_t kMostKept = 16;
  if (largest_.size() >= kMostKept) largest_.clear();
  return largest_[shape] = sampler_->LargestIrradiance(UnitTable(shape));
}

void DirectDaylight::Update(std::span<const std::shared_ptr<const SkyShape>> shapes) {
  summary_ = {};
  while (skies_.size() > shapes.size()) skies_.pop_back();
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    if (k == skies_.size()) {
      skies_.push_back(
          {nullptr, DaylightShadows(real_, objects_, sphere_, shadow_options_), {}, 0.0, {}});
    }
    Sky& sky = skies_[k];
    if (sky.shape != shapes[k]) {
      DaylightSamples drawn = sampler_->Draw(UnitTable(shapes[k]));
      sky.shadows.SetSamples(drawn.samples);
      sky.on_objects = sky.shadows.OnObjects(vertices_);
      sky.sky_share = drawn.sky_share;
      sky.samples = std::move(drawn.samples);
      sky.shape = shapes[k];
      summary_.maps_drawn += sky.shadows.MapsDrawn();
    }
    summary_.samples += sky.samples.size();
    summary_.sky_share += sky.sky_share / static_cast<double>(shapes.size());
  }
}

std::vector<DaylightSample> DirectDaylight::Samples() const {
  std::vector<DaylightSample> samples;
  for (const Sky& sky : skies_) {
    samples.insert(samples.end(), sky.samples.begin(), sky.samples.end());
  }
  return samples;
}

std::vector<glm::vec3> DirectDaylight::HiddenFrom(std::size_t k,
                                                  std::span<const Receiver> receivers) const {
  return skies_.at(k).shadows.HiddenFrom(receivers);
}

}  // namespace pleinair
