# Sourced by ./shirube and .ci/run: finds Python and keeps the virtual environments complete.

# A sourced ROS or another environment would be searched before our packages; and where Python may not write its bytecode,
# every start of a node compiles all modules again, which takes seconds.
forget_other_environments() {
    unset PYTHONPATH PYTHONHOME PYTHONSTARTUP PYTHONDONTWRITEBYTECODE VIRTUAL_ENV LD_LIBRARY_PATH LD_PRELOAD \
        AMENT_PREFIX_PATH COLCON_PREFIX_PATH CMAKE_PREFIX_PATH ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION \
        RMW_IMPLEMENTATION _ROS_WHEELS_BOOTSTRAP_COMPLETE PIP_TARGET PIP_PREFIX PIP_USER PIP_REQUIRE_VIRTUALENV
}

# find_python "3.12 3.11" prints the path of a Python of the first such version that can make environments.
# The shims of version managers may exist without working, so each candidate is run.
find_python() {
    local versions=$1 version path answer no_venv='' other=''
    local -a candidates=()
    for version in $versions; do
        while read -r path; do [ -n "$path" ] && candidates+=("$path"); done < <(type -aP "python$version")
        candidates+=(~/.pyenv/versions/"$version"*/bin/python3)
    done
    while read -r path; do [ -n "$path" ] && candidates+=("$path"); done < <(type -aP python3)
    for path in "${candidates[@]}"; do
        [ -x "$path" ] || continue
        answer=$("$path" -ISc 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) || continue
        if [[ " $versions " != *" $answer "* ]]; then
            other="$answer ($path)"
        elif "$path" -Ic 'import venv, ensurepip' 2>/dev/null; then
            printf '%s\n' "$path"
            return 0
        else
            no_venv=${no_venv:-"$answer ($path)"}
        fi
    done
    explain_missing_python "${versions// / or }" "$no_venv" "$other"
    return 1
}

explain_missing_python() {
    local wanted=$1 no_venv=$2 other=$3
    if [ -n "$no_venv" ]; then
        echo "shirube: Python $no_venv lacks the module venv; install it (Debian, Ubuntu:" \
            "apt install python${no_venv%% *}-venv) and try again" >&2
    elif [ -n "$other" ]; then
        echo "shirube: needs Python $wanted, found only $other; install one of them with its venv and try again" >&2
    else
        echo "shirube: needs Python $wanted, found none; install one of them with its venv and try again" >&2
    fi
}

# ensure_runtime ROOT: what nodes and commands need; ensure_development ROOT: what tests, checks and benchmarks need.
ensure_runtime() {
    ensure_environment "$1" .venv '3.12 3.11' runtime.lock
}

ensure_development() {
    ensure_environment "$1" .venv '3.12 3.11' runtime.lock dev.lock
}

# ensure_environment ROOT FOLDER "3.12 3.11" LOCK... makes or completes ROOT/FOLDER; quick when all is in place.
ensure_environment() {
    local root=$1 folder=$1/$2 versions=$3 python project version
    shift 3
    local -a wanted
    mapfile -t wanted < <(cd "$root/environment" && sha256sum -- "$@")
    project=$(cd "$root" && cat pyproject.toml <(printf "%s\n" src/*/*/__init__.py) | sha256sum)
    project=${project%% *}
    version=$("$folder/bin/python" -ISc 'import sys; print(sys.version.split()[0])' 2>/dev/null) || version=
    is_stamped "$folder/shirube.stamp" "python $version" "root $root" "${wanted[@]}" "project $project" && return 0
    if [ "$(uname -sm)" != 'Linux x86_64' ]; then
        echo "shirube: ROS 2 wheels exist for Linux on x86-64 only, this is $(uname -sm);" \
            "install ROS 2 Jazzy with apt and the rest with rosdep instead (docs/install.md)" >&2
        return 1
    fi
    python=$folder/bin/python
    if [ -z "$version" ] || [[ " $versions " != *" ${version%.*} "* ]]; then
        python=$(find_python "$versions") || return 1
    fi
    "$python" -IS "$root/environment/install.py" "$folder" "$project" "$@"
}

# is_stamped FILE LINE... returns whether a stamp has all lines.
is_stamped() {
    local stamp line
    [ -r "$1" ] || return 1
    stamp=$'\n'$(<"$1")$'\n'
    shift
    for line; do [[ $stamp == *$'\n'"$line"$'\n'* ]] || return 1; done
}
