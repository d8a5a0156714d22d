// SPDX-License-Identifier: MIT
// Point attributes, by the names that file readers use.
#pragma once

#include <stipple/attributes.h>
