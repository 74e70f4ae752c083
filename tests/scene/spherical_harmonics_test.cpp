#include "scene/spherical_harmonics.h"

#include <gtest/gtest.h>
