// SPDX-License-Identifier: MIT
#include "program/options/option_fields.h"

#include <string.h>

static const struct {
    const char *field, *option;
} names[] = {{"memory_limit_bytes", "--memory"}, {"unit_metres", "--unit"}};

void option_fields_name(const char* message, char* text, size_t size)
{
    size_t length = 0;
    while (*message != 0 && length + 1 < size) {
        const char* option = NULL;
        for (size_t i = 0; i < sizeof(names) / sizeof(names[0]) && option == NULL; ++i) {
            size_t taken = strlen(names[i].field);
            if (strncmp(message, names[i].field, taken) == 0) {
                option = names[i].option;
                message += taken;
            }
        }
        if (option == NULL) {
            text[length++] = *message++;
        }
        for (; option != NULL && *option != 0 && length + 1 < size; ++option) {
            text[length++] = *option;
        }
    }
    if (size != 0) {
        text[length] = 0;
    }
}
