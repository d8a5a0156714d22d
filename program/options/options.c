// SPDX-License-Identifier: MIT
#include "program/options/options.h"

#include "program/options/program.h"
#include "program/options/tool.h"

#include <assert.h>
#include <string.h>

enum { WORD_LIMIT = 63 }; // longer words get no suggestions

const option* options_common(void)
{
    tool_settings* settings = tool_settings_get();
    static option table[6];
    table[0] = (option){.name = "help",
                        .letter = 'h',
                        .help = "explain the command and its usual options",
                        .value = &settings->help,
                        .group = "Options of every command"};
    table[1] = (option){.name = "help-all",
                        .help = "explain the command and all its options",
                        .value = &settings->help_all};
    table[2] = (option){.name = "version", .help = "show the version", .value = &settings->version};
    table[3] = (option){.name = "quiet",
                        .letter = 'q',
                        .help = "print only errors, and no progress",
                        .value = &settings->quiet};
    table[4] = (option){
        .name = "verbose", .letter = 'v', .help = "print notices too", .value = &settings->verbose};
    return table;
}

static bool is_offered(const option* o)
{
    return !o->lab_only || program_get()->is_lab;
}

/// The heading of an entry of a table.
static const char* group_of(const option* table, const option* o)
{
    while (o > table && o->group == NULL) {
        o -= 1;
    }
    return o->group != NULL ? o->group : "Options";
}

/// Whether no entry before this one has its heading.
static bool begins_group(const option* table, const option* o)
{
    const char* group = group_of(table, o);
    for (const option* before = table; before < o; ++before) {
        if (strcmp(group_of(table, before), group) == 0) {
            return false;
        }
    }
    return true;
}

const option* options_of(const command* c)
{
    static const option none = {0};
    static option list[OPTION_TABLE_ROOM];
    const option* table = c->options != NULL ? c->options() : &none;
    size_t count = 0;
    for (const option* first = table; first->name != NULL; ++first) {
        const char* group = group_of(table, first);
        for (const option* o = first; begins_group(table, first) && o->name != NULL; ++o) {
            if (is_offered(o) && strcmp(group_of(table, o), group) == 0) {
                assert(count + 1 < OPTION_TABLE_ROOM && "OPTION_TABLE_ROOM is too small");
                list[count] = *o;
                list[count++].group = group;
            }
        }
    }
    list[count] = (option){0};
    return list;
}

static bool is_choice(const option* o)
{
    return o->type == OPTION_CHOICE || o->type == OPTION_SWITCH;
}

const char* options_argument(const option* o)
{
    if (o->argument != NULL) {
        return o->argument;
    }
    return is_choice(o) ? o->words : "";
}

const char* options_hidden_words(const option* o)
{
    bool shown = o->argument == NULL || strchr(o->argument, '|') != NULL;
    return is_choice(o) && !shown ? o->words : NULL;
}

static unsigned minimum(unsigned a, unsigned b)
{
    return a < b ? a : b;
}

// Optimal string alignment distance (Damerau 1964), three rows of the table at a time.
unsigned options_word_distance(const char* a, const char* b)
{
    size_t a_length = strlen(a), b_length = strlen(b);
    if (a_length > WORD_LIMIT || b_length > WORD_LIMIT) {
        return WORD_LIMIT;
    }
    unsigned rows[3][WORD_LIMIT + 1];
    for (size_t j = 0; j <= b_length; ++j) {
        rows[0][j] = (unsigned)j;
    }
    for (size_t i = 1; i <= a_length; ++i) {
        unsigned* row = rows[i % 3];
        const unsigned* above = rows[(i + 2) % 3];
        const unsigned* above2 = rows[(i + 1) % 3];
        row[0] = (unsigned)i;
        for (size_t j = 1; j <= b_length; ++j) {
            unsigned change = above[j - 1] + (a[i - 1] != b[j - 1]);
            row[j] = minimum(change, minimum(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
                row[j] = minimum(row[j], above2[j - 2] + 1);
            }
        }
    }
    return rows[a_length % 3][b_length];
}

static const option* find_long(const option* table, const char* name, size_t length)
{
    for (; table != NULL && table->name != NULL; ++table) {
        if (strlen(table->name) == length && memcmp(table->name, name, length) == 0) {
            return table;
        }
    }
    return NULL;
}

static const option* find_letter(const option* table, char letter)
{
    for (; table != NULL && table->name != NULL; ++table) {
        if (table->letter == letter) {
            return table;
        }
    }
    return NULL;
}

#ifndef NDEBUG
// A command's table must not repeat a name or letter, including those of the common options.
static bool table_is_sound(const option* table)
{
    for (const option* o = table; o != NULL && o->name != NULL; ++o) {
        const option* twin = find_long(o + 1, o->name, strlen(o->name));
        const option* letter_twin = o->letter != 0 ? find_letter(o + 1, o->letter) : NULL;
        const option* common = find_long(options_common(), o->name, strlen(o->name));
        const option* letter_common =
            o->letter != 0 ? find_letter(options_common(), o->letter) : NULL;
        if (twin != NULL || letter_twin != NULL || common != NULL || letter_common != NULL ||
            o->value == NULL || o->help == NULL || (o->lab_only && o->letter != 0) ||
            (is_choice(o) && o->words == NULL)) {
            return false;
        }
    }
    return true;
}
#endif

static void suggest(const option* table, const char* name, const option** best, unsigned* distance)
{
    for (; table != NULL && table->name != NULL; ++table) {
        unsigned d = is_offered(table) ? options_word_distance(name, table->name) : WORD_LIMIT;
        if (d < *distance || (d == *distance && *best == NULL)) {
            *best = table;
            *distance = d;
        }
    }
}

static int fail_unknown(const option* table, const char* name, size_t length)
{
    char word[WORD_LIMIT + 1];
    if (length > WORD_LIMIT) {
        return tool_usage_error("unknown option --%.*s", WORD_LIMIT, name);
    }
    memcpy(word, name, length);
    word[length] = 0;
    const option* best = NULL;
    unsigned distance = (unsigned)(length < 5 ? 1 : length / 3);
    suggest(table, word, &best, &distance);
    suggest(options_common(), word, &best, &distance);
    if (best != NULL) {
        return tool_usage_error("unknown option --%s; did you mean --%s?", word, best->name);
    }
    return tool_usage_error("unknown option --%s", word);
}

static int apply(const option* o, const char* value)
{
    char problem[256];
    if (!option_set_value(o, value, problem, sizeof(problem))) {
        return tool_usage_error("--%s: '%s' %s", o->name, value, problem);
    }
    if (o->given != NULL) {
        *o->given = true;
    }
    return 0;
}

// Whether an argument can be the value of an option with an optional value: a number such as "2" or
// "0.5", but not a file name.
static bool is_plain_number(const char* text)
{
    return text != NULL && *text != 0 && strspn(text, "0123456789.") == strlen(text);
}

// A word that means 0, for an option with an optional value.
static bool is_zero_word(const option* o, const char* text)
{
    size_t length = strcspn(o->words, "|");
    return text != NULL && o->words[length] == '|' && strlen(text) == length &&
           memcmp(text, o->words, length) == 0;
}

// "name" or "name=value" after the two dashes; `next` is the argument after it, or NULL.
static int parse_long(const option* table, const char* text, const char* next, int* used)
{
    size_t length = strcspn(text, "=");
    const option* found = find_long(table, text, length);
    found = found != NULL ? found : find_long(options_common(), text, length);
    if (found == NULL) {
        return fail_unknown(table, text, length);
    }
    if (!is_offered(found)) {
        return tool_usage_error("--%s is an option of stipple-lab", found->name);
    }
    if (found->type == OPTION_FLAG) {
        return text[length] == '=' ? tool_usage_error("--%s takes no value", found->name)
                                   : apply(found, "");
    }
    if (text[length] == '=') {
        return apply(found, text + length + 1);
    }
    if (found->fallback != NULL && !is_plain_number(next) && !is_zero_word(found, next)) {
        return apply(found, found->fallback);
    }
    if (next == NULL) {
        return tool_usage_error("--%s needs a value: %s", found->name, options_argument(found));
    }
    *used = 2;
    return apply(found, next);
}

// The letters after one dash: flags, and at most one option with a value, which takes the rest.
static int parse_letters(const option* table, const char* letters, const char* next, int* used)
{
    for (; *letters != 0; ++letters) {
        const option* found = find_letter(table, *letters);
        found = found != NULL ? found : find_letter(options_common(), *letters);
        if (found == NULL) {
            return tool_usage_error("unknown option -%c", *letters);
        }
        if (found->type != OPTION_FLAG) {
            if (letters[1] != 0) {
                return apply(found, letters + 1);
            }
            if (next == NULL) {
                return tool_usage_error("-%c needs a value: %s", *letters, options_argument(found));
            }
            *used = 2;
            return apply(found, next);
        }
        int code = apply(found, "");
        if (code != 0) {
            return code;
        }
    }
    return 0;
}

int options_parse(const option* table, int* argc, char** argv)
{
    assert(table_is_sound(table) && "a command's option table repeats a name or lacks a value");
    int left = 0;
    bool only_arguments = false;
    for (int i = 0; i < *argc;) {
        char* text = argv[i];
        const char* next = i + 1 < *argc ? argv[i + 1] : NULL;
        int used = 1, code = 0;
        if (only_arguments || text[0] != '-' || text[1] == 0) {
            assert(left <= i && "arguments move to the front");
            argv[left++] = text;
        } else if (strcmp(text, "--") == 0) {
            only_arguments = true;
        } else if (text[1] == '-') {
            code = parse_long(table, text + 2, next, &used);
        } else {
            code = parse_letters(table, text + 1, next, &used);
        }
        if (code != 0) {
            return code;
        }
        i += used;
    }
    *argc = left;
    return 0;
}

static const struct {
    const char* field; ///< of the library's interface
    const char* shown; ///< the option that sets it
} field_options[] = {{"memory_limit_bytes", "--memory"}, {"unit_metres", "--unit"}};

void option_fields_name(const char* message, char* text, size_t size)
{
    size_t length = 0;
    while (*message != 0 && length + 1 < size) {
        const char* shown = NULL;
        for (size_t i = 0; i < sizeof(field_options) / sizeof(field_options[0]) && shown == NULL;
             ++i) {
            size_t taken = strlen(field_options[i].field);
            if (strncmp(message, field_options[i].field, taken) == 0) {
                shown = field_options[i].shown;
                message += taken;
            }
        }
        if (shown == NULL) {
            text[length++] = *message++;
        }
        for (; shown != NULL && *shown != 0 && length + 1 < size; ++shown) {
            text[length++] = *shown;
        }
    }
    if (size != 0) {
        text[length] = 0;
    }
}
