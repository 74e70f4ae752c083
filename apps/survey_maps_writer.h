// The survey's maps as files: what `prepare --maps` leaves.
#pragma once

#include <filesystem>

#include "relight/prepared_scene.h"

namespace pleinair {

// Writes albedo, normal, ambient_weight, sun_visibility, sky and relit (the map under its own
// light, without the disc). Each is lat-long, as .exr with the values and as .png to look at.
// survey.json has the survey's sun and sky, and how well they and the albedos are known. Throws
// std::runtime_error for a scene without a survey, or naming the file that can't be written.
void WriteSurveyMaps(const PreparedScene& scene, const std::filesystem::path& folder);

}  // namespace pleinair
