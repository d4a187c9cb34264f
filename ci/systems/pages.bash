# Commands on the pages of the documentation.

# The commands of a section, a line each, without their comments.
page_commands() { # PAGE SECTION
    awk -v section="## $2" '
        /^## / { here = ($0 == section) }
        /^```/ { block = here && !block; next }
        block { sub(/ +#.*/, ""); if (NF) print }
    ' "$workspace/$1"
}
