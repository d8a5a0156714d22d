// SPDX-License-Identifier: MIT
//
// Shell completions, from the tables of the commands.
#include "program/options/options.h"
#include "program/options/program.h"
#include "program/options/tool.h"

#include <string.h>

// Possible values: the option's words, separated by spaces; for numbers, the words that mean 0.
static void print_words(FILE* stream, const option* o)
{
    const char* gap = "";
    for (const char* word = o->words; word != NULL && *word != 0;) {
        size_t length = strcspn(word, "|");
        bool is_range = memchr(word, '.', length) != NULL;
        if (!is_range) {
            fprintf(stream, "%s%.*s", gap, (int)length, word);
            gap = " ";
        }
        word += length + (word[length] == '|');
    }
}

// Prints `text` with a backslash before each character of `special`, and quotes as the shell wants
// them.
static void print_quoted(FILE* stream, const char* text, const char* special, const char* quote)
{
    for (; *text != 0; ++text) {
        if (*text == '\'') {
            fputs(quote, stream);
        } else {
            fprintf(stream, "%s%c", strchr(special, *text) != NULL ? "\\" : "", *text);
        }
    }
}

/// The name of a program in that of a shell function: with underscores.
static void print_function_name(FILE* stream, const char* name)
{
    for (; *name != 0; ++name) {
        putc(*name == '-' ? '_' : *name, stream);
    }
}

static void print_command_names(FILE* stream)
{
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fprintf(stream, "%s%s", c != commands() ? " " : "", (*c)->name);
    }
}

static void print_bash_values(FILE* stream, const command* c)
{
    for (const option* o = options_of(c); o->name != NULL; ++o) {
        if (o->type == OPTION_FLAG || o->type == OPTION_TEXT || o->type == OPTION_TEXTS) {
            continue; // after a text come file names
        }
        fprintf(stream, "    %s:--%s", c->name, o->name);
        if (o->letter != 0) {
            fprintf(stream, " | %s:-%c", c->name, o->letter);
        }
        fputs(") COMPREPLY=($(compgen -W '", stream);
        print_words(stream, o);
        fputs("' -- \"$cur\")); return ;;\n", stream);
    }
}

static void print_bash_options(FILE* stream, const option* table)
{
    for (; table->name != NULL; ++table) {
        fprintf(stream, " --%s", table->name);
    }
}

void completion_print_bash(FILE* stream)
{
    const char* name = program_get()->name;
    fprintf(stream, "# bash completion for %s, made from the tables of options. Do not edit.\n",
            name);
    fputs("_", stream);
    print_function_name(stream, name);
    fputs("()\n{\n"
          "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} command= "
          "names= i\n"
          "    if [[ $cur == = ]]; then\n"
          "        cur=\n"
          "    elif [[ $prev == = ]]; then\n"
          "        prev=${COMP_WORDS[COMP_CWORD-2]}\n"
          "    fi\n"
          "    for ((i = 1; i < COMP_CWORD; ++i)); do\n"
          "        if [[ ${COMP_WORDS[i]} != -* ]]; then\n"
          "            command=${COMP_WORDS[i]}\n"
          "            break\n"
          "        fi\n"
          "    done\n"
          "    COMPREPLY=()\n"
          "    if [[ -z $command ]]; then\n"
          "        COMPREPLY=($(compgen -W '",
          stream);
    print_command_names(stream);
    print_bash_options(stream, options_common());
    fputs("' -- \"$cur\"))\n        return\n    fi\n    case $command:$prev in\n", stream);
    for (const command* const* c = commands(); *c != NULL; ++c) {
        print_bash_values(stream, *c);
    }
    fputs("    esac\n    case $command in\n", stream);
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fprintf(stream, "    %s) names='", (*c)->name);
        print_bash_options(stream, options_of(*c));
        print_bash_options(stream, options_common());
        fputs("' ;;\n", stream);
    }
    fputs("    esac\n"
          "    if [[ $command == help && $cur != -* ]]; then\n"
          "        COMPREPLY=($(compgen -W '",
          stream);
    print_command_names(stream);
    fputs("' -- \"$cur\"))\n"
          "    elif [[ $cur == -* ]]; then\n"
          "        COMPREPLY=($(compgen -W \"$names\" -- \"$cur\"))\n"
          "    else\n"
          "        COMPREPLY=($(compgen -f -- \"$cur\"))\n"
          "    fi\n"
          "}\n"
          "complete -o filenames -F _",
          stream);
    print_function_name(stream, name);
    fprintf(stream, " %s\n", name);
}

static void print_zsh_option(FILE* stream, const option* o)
{
    if (o->letter != 0) {
        fprintf(stream, "            '(-%c --%s)'{-%c,--%s}'[", o->letter, o->name, o->letter,
                o->name);
    } else {
        fprintf(stream, "            '--%s[", o->name);
    }
    print_quoted(stream, o->help, "[]:\\", "'\\''");
    fputs("]", stream);
    if (o->type == OPTION_TEXT || o->type == OPTION_TEXTS) {
        fputs(":value:_files", stream);
    } else if (o->type != OPTION_FLAG) {
        fputs(":value:(", stream);
        print_words(stream, o);
        fputs(")", stream);
    }
    fputs("' \\\n", stream);
}

void completion_print_zsh(FILE* stream)
{
    const char* name = program_get()->name;
    fprintf(stream, "#compdef %s\n# Made from the tables of options. Do not edit.\n_", name);
    print_function_name(stream, name);
    fputs("()\n{\n"
          "    local -a list=(\n",
          stream);
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fprintf(stream, "        '%s:", (*c)->name);
        print_quoted(stream, (*c)->summary, ":\\", "'\\''");
        fputs("'\n", stream);
    }
    fputs("    )\n"
          "    if (( CURRENT == 2 )); then\n"
          "        _describe command list\n"
          "        return\n"
          "    fi\n"
          "    local command=$words[2]\n"
          "    shift words\n"
          "    (( CURRENT-- ))\n"
          "    case $command in\n",
          stream);
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fprintf(stream, "    %s)\n        _arguments \\\n", (*c)->name);
        for (const option* o = options_of(*c); o->name != NULL; ++o) {
            print_zsh_option(stream, o);
        }
        for (const option* o = options_common(); o->name != NULL; ++o) {
            print_zsh_option(stream, o);
        }
        if (strcmp((*c)->name, "help") == 0) {
            fputs("            '1:command:(", stream);
            print_command_names(stream);
            fputs(")'\n", stream);
        } else {
            fputs("            '*:file:_files'\n", stream);
        }
        fputs("        ;;\n", stream);
    }
    fputs("    esac\n}\n_", stream);
    print_function_name(stream, name);
    fputs(" \"$@\"\n", stream);
}

static void print_fish_option(FILE* stream, const char* command_name, const option* o)
{
    fprintf(stream, "complete -c %s", program_get()->name);
    if (command_name != NULL) {
        fprintf(stream, " -n '__fish_seen_subcommand_from %s'", command_name);
    }
    fprintf(stream, " -l %s", o->name);
    if (o->letter != 0) {
        fprintf(stream, " -s %c", o->letter);
    }
    if (o->type == OPTION_TEXT || o->type == OPTION_TEXTS) {
        fputs(" -r", stream);
    } else if (o->type != OPTION_FLAG) {
        fputs(" -x -a '", stream);
        print_words(stream, o);
        fputs("'", stream);
    }
    fputs(" -d '", stream);
    print_quoted(stream, o->help, "\\", "\\'");
    fputs("'\n", stream);
}

void completion_print_fish(FILE* stream)
{
    const char* name = program_get()->name;
    fprintf(stream, "# fish completion for %s, made from the tables of options. Do not edit.\n",
            name);
    for (const option* o = options_common(); o->name != NULL; ++o) {
        print_fish_option(stream, NULL, o);
    }
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fprintf(stream, "complete -c %s -f -n __fish_use_subcommand -a %s -d '", name, (*c)->name);
        print_quoted(stream, (*c)->summary, "\\", "\\'");
        fputs("'\n", stream);
        for (const option* o = options_of(*c); o->name != NULL; ++o) {
            print_fish_option(stream, (*c)->name, o);
        }
    }
    fprintf(stream, "complete -c %s -f -n '__fish_seen_subcommand_from help' -a '", name);
    print_command_names(stream);
    fputs("'\n", stream);
}
