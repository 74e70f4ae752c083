#include "relight/sky_shape.h"
