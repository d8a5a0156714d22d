// SPDX-License-Identifier: MIT
// Attributes of points, by the name under which readers of files know them.
#pragma once

#include <stipple/attributes.h>
