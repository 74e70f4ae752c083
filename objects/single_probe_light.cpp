#include "objects/single_probe_light.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/spherical_harmonics.h"

namespace pleinair {
namespace {

// To compare places: rays 6 deg apart, facings 25 deg apart.
constexpr int kComparingRays = 1024;
constexpr int kFacings = 64;
constexpr float kPulledIn = 0.99f;

// The middle, the corners and the middles of the sides.
std::vector<glm::vec3> PlacesOf(const BoundingBox& box) {
  const glm::vec3 middle_m = 0.5f * (box.lower_m + box.upper_m);
  const glm::vec3 half_m = 0.5f * kPulledIn * (box.upper_m - box.lower_m);
  std::vector<glm::vec3> places_m{middle_m};
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int off_middle = std::abs(x) + std::abs(y) + std::abs(z);
        if (off_middle != 1 && off_middle != 3) continue;
        places_m.push_back(middle_m + glm::vec3(x, y, z) * half_m);
      }
    }
  }
  return places_m;
}

// Evenly over the sphere, both poles among them.
std::vector<glm::vec3> Facings() {
  std::vector<glm::vec3> facings;
  for (int i = 0; i < kFacings; ++i) {
    const float height = 1.0f - 2.0f * static_cast<float>(i) / (kFacings - 1);
    const float radius = std::sqrt(std::max(1.0f - height * height, 0.0f));
    const float azimuth_rad =
        2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / std::numbers::phi_v<float>;
    facings.emplace_back(radius * std::cos(azimuth_rad), radius * std::sin(azimuth_rad), height);
  }
  return facings;
}

// Irradiance of a surface that faces along `normal`.
glm::vec3 IrradianceOf(std::span<const glm::vec3> radiance,
                       std::span<const glm::vec3> directions,
                       const glm::vec3& normal) {
  glm::vec3 sum(0.0f);
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    sum += std::max(glm::dot(normal, directions[i]), 0.0f) * radiance[i];
  }
  return 4.0f * std::numbers::pi_v<float> / static_cast<float>(directions.size()) * sum;
}

}  // namespace

SingleProbeLight::SingleProbeLight(const PatchScene& real, const SingleProbeOptions& options)
    : real_(real), options_(options), facings_(Facings()), facing_basis_(BasisAt(facings_)) {}

std::vector<float> SingleProbeLight::BasisAt(std::span<const glm::vec3> directions) const {
  const auto count = static_cast<std::size_t>(ShCoefficientCount(options_.sh_bands));
  std::vector<float> basis(directions.size() * count);
  tbb::parallel_for(std::size_t{0}, directions.size(), [&](std::size_t i) {
    std::vector<double> values(count);
    EvaluateShBasis(options_.sh_bands, glm::dvec3(directions[i]), values);
    std::copy(values.begin(), values.end(), basis.begin() + std::ptrdiff_t(i * count));
  });
  return basis;
}

void SingleProbeLight::Pose(const Mesh& objects) {
  normals_ = objects.normals;
  places_m_.clear();
  if (!objects.Empty()) places_m_ = PlacesOf(BoundingBoxOf(objects));
  here_ = there_ = SphereView();
  normal_basis_.clear();
  lights_.clear();
  done_ = {};
  comparisons_.clear();
  compared_ = {};
}

void SingleProbeLight::Update(const FrameBasis& basis, const Lighting& lighting) {
  const std::vector<std::size_t> stale = done_.StaleIn(basis, lighting);
  if (stale.empty() || places_m_.empty()) return;
  if (here_.PlaceCount() == 0) {
    here_ = SphereView(real_, std::span(places_m_).first(1), options_.rays, options_.seed);
    if (direction_basis_.empty()) direction_basis_ = BasisAt(here_.Directions());
    normal_basis_ = BasisAt(normals_);
  }
  lights_.resize(basis.LightCount());
  for (const std::size_t light : stale) {
    lights_[light] = Make(basis.Sky(light), basis.FaceRadiosity(light));
    done_.Done(basis, light);
  }
}

void SingleProbeLight::UpdateOthers(const FrameBasis& basis, const Lighting& lighting) {
  Update(basis, lighting);
  const std::vector<std::size_t> stale = compared_.StaleIn(basis, lighting);
  if (stale.empty() || places_m_.empty()) return;
  if (there_.PlaceCount() == 0) {
    there_ = SphereView(real_, places_m_, kComparingRays, options_.seed);
  }
  comparisons_.resize(basis.LightCount());
  for (const std::size_t light : stale) {
    comparisons_[light] =
        MakeComparison(lights_[light], basis.Sky(light), basis.FaceRadiosity(light));
    compared_.Done(basis, light);
  }
}

SingleProbeLight::OfLight SingleProbeLight::Make(const SkyShape* sky,
                                                 std::span<const glm::vec3> face_radiosity) const {
  OfLight light;
  light.radiance = here_.Radiance(0, sky, face_radiosity);
  const int bands = options_.sh_bands;
  std::vector<glm::dvec3> sums(static_cast<std::size_t>(ShCoefficientCount(bands)),
                               glm::dvec3(0.0));
  for (std::size_t i = 0; i < light.radiance.size(); ++i) {
    const float* const basis = direction_basis_.data() + i * sums.size();
    for (std::size_t k = 0; k < sums.size(); ++k) {
      sums[k] += double{basis[k]} * glm::dvec3(light.radiance[i]);
    }
  }
  const double solid_angle = 4.0 * std::numbers::pi / double(light.radiance.size());
  for (int band = 0; band < bands; ++band) {
    for (int k = band * band; k < (band + 1) * (band + 1); ++k) {
      light.coefficients.emplace_back(solid_angle * CosineLobeFactor(band) *
                                      sums[static_cast<std::size_t>(k)]);
    }
  }
  return light;
}

SingleProbeLight::Comparison SingleProbeLight::MakeComparison(
    const OfLight& light, const SkyShape* sky, std::span<const glm::vec3> face_radiosity) const {
  Comparison comparison;
  for (std::size_t i = 0; i < facings_.size(); ++i) {
    comparison.here.push_back(
        Irradiance(light, facing_basis_.data() + i * light.coefficients.size()));
  }
  std::vector<std::vector<glm::vec3>> seen(there_.PlaceCount());
  tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t place) {
    const std::vector<glm::vec3> radiance = there_.Radiance(place, sky, face_radiosity);
    for (const glm::vec3& facing : facings_) {
      seen[place].push_back(IrradianceOf(radiance, there_.Directions(), facing));
    }
  });
  // The harmonics' error here, and the difference of the light there.
  for (std::size_t place = 1; place < seen.size(); ++place) {
    for (std::size_t i = 0; i < facings_.size(); ++i) {
      comparison.there.push_back(IrradianceOf(light.radiance, here_.Directions(), facings_[i]) +
                                 seen[place][i] - seen[0][i]);
    }
  }
  return comparison;
}

glm::vec3 SingleProbeLight::Irradiance(const OfLight& light, const float* basis) {
  glm::vec3 irradiance(0.0f);
  for (std::size_t k = 0; k < light.coefficients.size(); ++k) {
    irradiance += basis[k] * light.coefficients[k];
  }
  return glm::max(irradiance, glm::vec3(0.0f));
}

std::vector<glm::vec3> SingleProbeLight::OnObjects(std::size_t light) const {
  const OfLight& of_light = lights_.at(light);
  std::vector<glm::vec3> irradiance(normals_.size());
  tbb::parallel_for(std::size_t{0}, normals_.size(), [&](std::size_t v) {
    irradiance[v] = Irradiance(of_light, normal_basis_.data() + v * of_light.coefficients.size());
  });
  return irradiance;
}

std::vector<SingleProbeLight::Compared> SingleProbeLight::Compare(const Lighting& lighting) const {
  std::vector<Compared> compared;
  for (std::size_t light = 0; light < comparisons_.size(); ++light) {
    const glm::vec3 intensity = IntensityOf(lighting, light);
    const Comparison& of_light = comparisons_[light];
    if (intensity == glm::vec3(0.0f) || of_light.there.empty()) continue;
    compared.resize(of_light.there.size());
    for (std::size_t i = 0; i < compared.size(); ++i) {
      compared[i].here += intensity * of_light.here[i % facings_.size()];
      compared[i].there += intensity * of_light.there[i];
    }
  }
  return compared;
}

glm::vec3 SingleProbeLight::LargestRadiance(const Lighting& lighting) const {
  std::vector<glm::vec3> radiance(here_.Directions().size(), glm::vec3(0.0f));
  glm::vec3 largest(0.0f);
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    for (std::size_t light = 0; light < lights_.size(); ++light) {
      if (lights_[light].radiance.empty()) continue;
      radiance[i] += IntensityOf(lighting, light) * lights_[light].radiance[i];
    }
    largest = glm::max(largest, radiance[i]);
  }
  return largest;
}

}  // namespace pleinair
