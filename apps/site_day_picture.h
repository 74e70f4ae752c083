// A day at a site as a picture: panels of hours, and the light's uncertainty over the day.
#pragma once

#include <string>

#include "scene/image.h"
#include "session/check/site_forecast.h"

namespace pleinair {

// A panel for each hour that has kept its picture. Throws std::invalid_argument for a day without
// an hour of sun.
Rgb8Image DrawSiteDay(const std::string& title, const SiteDay& day);

}  // namespace pleinair
