// Sun and sky as an HDR environment map shows them.
#pragma once

#include "relight/survey/survey.h"
#include "scene/image.h"

namespace pleinair {

// Splits the map's light into the sun's disc and the sky, and fills what surfaces hide of the sky.
// `shows_sky`  not zero where the map's pixel sees past the scene, above the horizon.
// `sun_seen`   share of the disc that the scene leaves free at the map's place.
SurveyLight MeasureSurveyLight(const SurveyMap& map, const Gray8Image& shows_sky, double sun_seen);

}  // namespace pleinair
