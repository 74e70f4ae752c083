#include "relight/irradiance_volume.h"
