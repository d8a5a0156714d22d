// SPDX-License-Identifier: MIT
#include "program/options/options.h"

#include <assert.h>
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PIXEL_LIMIT 32768.0
#define KILOBYTE 1024.0
#define SHORTEST_DIRECTION 1e-30 ///< lengths from here to LONGEST_DIRECTION can be normalized
#define LONGEST_DIRECTION 1e30

/// The allowed `words` of a number.
typedef struct number_rule {
    bool is_zero_word;
    double low, high;
} number_rule;

static bool is_range(const char* word, size_t length)
{
    for (size_t i = 0; i + 1 < length; ++i) {
        if (word[i] == '.' && word[i + 1] == '.') {
            return true;
        }
    }
    return false;
}

static number_rule read_rule(const char* words, const char* text)
{
    number_rule rule = {.low = -HUGE_VAL, .high = HUGE_VAL};
    for (const char* word = words; word != NULL && *word != 0;) {
        size_t length = strcspn(word, "|");
        if (is_range(word, length)) {
            rule.low = strtod(word, NULL);
            const char* high = strstr(word, "..") + 2;
            rule.high = *high >= '0' && *high <= '9' ? strtod(high, NULL) : HUGE_VAL;
        } else if (strlen(text) == length && memcmp(word, text, length) == 0) {
            rule.is_zero_word = true;
        }
        word += length + (word[length] == '|');
    }
    assert(rule.low <= rule.high && "the option allows no value");
    return rule;
}

static bool check_range(double value, number_rule rule, char* problem, size_t size)
{
    if (value < rule.low || value > rule.high) {
        snprintf(problem, size, "is not within %.15g and %.15g", rule.low, rule.high);
        return false;
    }
    return true;
}

static bool fail(char* problem, size_t size, const char* text)
{
    snprintf(problem, size, "%s", text);
    return false;
}

static bool read_whole(const char* text, uint64_t* value, const char** end)
{
    if (*text < '0' || *text > '9') {
        return false;
    }
    char* stop;
    errno = 0;
    *value = strtoull(text, &stop, 10);
    *end = stop;
    return errno == 0;
}

static bool read_number(const char* text, double* value, const char** end)
{
    if (strchr("+-.0123456789", *text) == NULL || *text == 0) {
        return false;
    }
    char* stop;
    *value = strtod(text, &stop);
    *end = stop;
    return stop != text && isfinite(*value);
}

static bool set_count(const option* o, const char* text, char* problem, size_t size)
{
    number_rule rule = read_rule(o->words, text);
    uint64_t value = 0;
    const char* end = "";
    if (!rule.is_zero_word) {
        if (!read_whole(text, &value, &end) || *end != 0) {
            return fail(problem, size, "is not a whole number");
        }
        if (!check_range((double)value, rule, problem, size)) {
            return false;
        }
    }
    *(uint64_t*)o->value = value;
    return true;
}

static bool set_whole(const option* o, const char* text, char* problem, size_t size)
{
    uint64_t value = 0;
    option wide = *o;
    wide.value = &value;
    if (!set_count(&wide, text, problem, size) ||
        !check_range((double)value, (number_rule){.high = UINT32_MAX}, problem, size)) {
        return false;
    }
    *(uint32_t*)o->value = (uint32_t)value;
    return true;
}

static bool set_number(const option* o, const char* text, char* problem, size_t size)
{
    number_rule rule = read_rule(o->words, text);
    double value = 0;
    const char* end = "";
    if (!rule.is_zero_word) {
        if (!read_number(text, &value, &end) || *end != 0) {
            return fail(problem, size, "is not a number");
        }
        if (!check_range(value, rule, problem, size)) {
            return false;
        }
    }
    *(double*)o->value = value;
    return true;
}

static bool set_float(const option* o, const char* text, char* problem, size_t size)
{
    double value = 0.0;
    option wide = *o;
    wide.value = &value;
    if (!set_number(&wide, text, problem, size)) {
        return false;
    }
    double scaled = o->scale != 0.0 ? o->scale * value : value;
    if (fabs(scaled) > (double)FLT_MAX) {
        return fail(problem, size, "is too large");
    }
    *(float*)o->value = (float)scaled;
    return true;
}

// The power of two of a unit: "", B, K, M, G, T, each letter also as KB and KiB.
static bool read_unit(const char* text, unsigned* shift)
{
    static const char letters[] = "KMGT";
    *shift = 0;
    const char* letter =
        *text != 0 ? strchr(letters, *text >= 'a' ? *text - 'a' + 'A' : *text) : NULL;
    if (letter != NULL) {
        *shift = 10 * (unsigned)(letter - letters + 1);
        text += 1 + (text[1] == 'i' && text[2] == 'B');
    }
    return text[*text == 'B'] == 0;
}

static bool set_size(const option* o, const char* text, char* problem, size_t size)
{
    number_rule rule = read_rule(o->words, text);
    uint64_t value = 0;
    if (!rule.is_zero_word) {
        const char *end, *fraction_end;
        double fraction = 0;
        unsigned shift;
        bool ok = read_whole(text, &value, &end);
        if (ok && *end == '.') {
            ok = read_number(end, &fraction, &fraction_end);
            end = fraction_end;
        }
        if (!ok || !read_unit(end, &shift)) {
            return fail(problem, size, "is not a size such as 512M or 8G");
        }
        if (value > UINT64_MAX >> 1 >> shift) {
            return fail(problem, size, "is too large");
        }
        value = (value << shift) + (uint64_t)(fraction * (double)(UINT64_C(1) << shift));
        if ((double)value < rule.low && isinf(rule.high)) {
            snprintf(problem, size, "is too small: expected at least %.15gK", rule.low / KILOBYTE);
            return false;
        }
        if (!check_range((double)value, rule, problem, size)) {
            return false;
        }
    }
    *(uint64_t*)o->value = value;
    return true;
}

static bool set_partial_file(const option* o, const char* text, char* problem, size_t size)
{
    option_partial_file part = {0};
    const char* end;
    if (strchr(text, '%') == NULL) {
        option bytes = {.words = "1..9e18", .value = &part.bytes};
        if (!set_size(&bytes, text, problem, size)) {
            return fail(problem, size,
                        "is neither a size such as 65536 or 64K nor a percentage "
                        "such as 5%");
        }
    } else if (!read_number(text, &part.percent, &end) || strcmp(end, "%") != 0 ||
               !(part.percent > 0.0 && part.percent <= 100.0)) {
        return fail(problem, size, "is not a percentage such as 5%, above 0 and at most 100%");
    }
    *(option_partial_file*)o->value = part;
    return true;
}

static bool set_choice(const option* o, const char* text, char* problem, size_t size)
{
    size_t length = strlen(text);
    int index = 0;
    for (const char* word = o->words;; ++index) {
        size_t word_length = strcspn(word, "|");
        if (word_length == length && memcmp(word, text, length) == 0) {
            *(int*)o->value = index;
            return true;
        }
        if (word[word_length] == 0) {
            const char* words = options_hidden_words(o);
            snprintf(problem, size, "is not one of %s",
                     words != NULL ? words : options_argument(o));
            return false;
        }
        word += word_length + 1;
    }
}

static bool set_switch(const option* o, const char* text, char* problem, size_t size)
{
    int index = 0;
    option choice = *o;
    choice.value = &index;
    if (!set_choice(&choice, text, problem, size)) {
        return false;
    }
    *(bool*)o->value = index == 1;
    return true;
}

static bool set_pixels(const option* o, const char* text, char* problem, size_t size)
{
    number_rule rule = read_rule(o->words, text);
    uint64_t width = 0, height = 0;
    if (!rule.is_zero_word) {
        const char* end;
        bool ok = read_whole(text, &width, &end) && (*end == 'x' || *end == 'X' || *end == ',') &&
                  read_whole(end + 1, &height, &end) && *end == 0;
        if (!ok) {
            return fail(problem, size, "is not a size such as 1920x1080");
        }
        rule.low = rule.low < 1.0 ? 1.0 : rule.low;
        rule.high = rule.high > PIXEL_LIMIT ? PIXEL_LIMIT : rule.high;
        if (!check_range((double)width, rule, problem, size) ||
            !check_range((double)height, rule, problem, size)) {
            return false;
        }
    }
    uint32_t* value = o->value;
    value[0] = (uint32_t)width;
    value[1] = (uint32_t)height;
    return true;
}

// "x" is 1, "-z" is -3; 0 if the text is not an axis.
static int read_axis(const char* text)
{
    int sign = *text == '-' ? -1 : 1;
    text += *text == '-' || *text == '+' ? 1 : 0;
    return *text >= 'x' && *text <= 'z' && text[1] == 0 ? sign * (*text - 'x' + 1) : 0;
}

static bool set_color(const option* o, const char* text, char* problem, size_t size)
{
    return color_parse(text, o->value) ||
           fail(problem, size, "is not a colour such as white, steelblue, #fff or #dfe3e8");
}

static bool set_vector(const option* o, const char* text, char* problem, size_t size)
{
    double values[3] = {0.0};
    const char* end = text;
    int axis = o->words != NULL ? read_axis(text) : 0;
    if (axis != 0) {
        values[abs(axis) - 1] = axis > 0 ? 1.0 : -1.0;
        memcpy(o->value, values, sizeof(values));
        return true;
    }
    for (int i = 0; i < 3; ++i) {
        if (!read_number(end, &values[i], &end) || *end != (i < 2 ? ',' : 0)) {
            return fail(
                problem, size,
                o->words != NULL
                    ? "is neither an axis such as z or -x nor three numbers such as 1,2.5,-3"
                    : "is not three numbers such as 1,2.5,-3");
        }
        end += i < 2;
    }
    double length = sqrt(values[0] * values[0] + values[1] * values[1] + values[2] * values[2]);
    if (o->words != NULL && !(length >= SHORTEST_DIRECTION && length <= LONGEST_DIRECTION)) {
        return fail(problem, size,
                    length < 1.0 ? "has no length: expected a direction such as 0,0,1"
                                 : "is too long: expected a direction such as 0,0,1");
    }
    memcpy(o->value, values, sizeof(values));
    return true;
}

static bool add_text(const option* o, const char* text, char* problem, size_t size)
{
    option_texts* texts = o->value;
    if (texts->count == OPTION_TEXTS_MAX) {
        return fail(problem, size, "exceeds the number of repetitions");
    }
    texts->texts[texts->count++] = text;
    return true;
}

bool option_set_value(const option* o, const char* text, char* problem, size_t problem_size)
{
    switch (o->type) {
    case OPTION_FLAG:
        *(bool*)o->value = true;
        return true;
    case OPTION_TEXT:
        *(const char**)o->value = text;
        return true;
    case OPTION_TEXTS:
        return add_text(o, text, problem, problem_size);
    case OPTION_COUNT:
        return set_count(o, text, problem, problem_size);
    case OPTION_WHOLE:
        return set_whole(o, text, problem, problem_size);
    case OPTION_FLOAT:
        return set_float(o, text, problem, problem_size);
    case OPTION_SWITCH:
        return set_switch(o, text, problem, problem_size);
    case OPTION_NUMBER:
        return set_number(o, text, problem, problem_size);
    case OPTION_SIZE:
        return set_size(o, text, problem, problem_size);
    case OPTION_CHOICE:
        return set_choice(o, text, problem, problem_size);
    case OPTION_PIXELS:
        return set_pixels(o, text, problem, problem_size);
    case OPTION_COLOR:
        return set_color(o, text, problem, problem_size);
    case OPTION_VECTOR:
        return set_vector(o, text, problem, problem_size);
    case OPTION_PARTIAL_FILE:
        return set_partial_file(o, text, problem, problem_size);
    }
    return fail(problem, problem_size, "cannot be read");
}
