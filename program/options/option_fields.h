// SPDX-License-Identifier: MIT
// Messages of the library name fields of its interface; users of the program know its options.
#pragma once

#include <stddef.h>

/// Copies a message, with each field's name replaced by that of the option which sets it. Cut to
/// `size` bytes.
void option_fields_name(const char* message, char* text, size_t size);
