// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/options/options.h"

#include <string.h>

void test_option_fields_become_options(test_state* test)
{
    char text[64];
    option_fields_name("(memory_limit_bytes), unit_metres", text, sizeof(text));
    CHECK(strcmp(text, "(--memory), --unit") == 0);
    option_fields_name("memory_limit", text, sizeof(text));
    CHECK(strcmp(text, "memory_limit") == 0);
    option_fields_name("", text, sizeof(text));
    CHECK(text[0] == 0);
    // truncated, but always terminated
    option_fields_name("use unit_metres", text, 8);
    CHECK(strcmp(text, "use --u") == 0);
    memset(text, 'x', sizeof(text));
    option_fields_name("a", text, 0);
    CHECK(text[0] == 'x');
}
