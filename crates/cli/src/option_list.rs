//! The commands and their options as data, from which other languages make theirs.

use crate::args::command;
use clap::{Arg, ArgAction};
use serde_json::{Value, json};

/// Each command that prints JSON, with its options: name, help, whether it is a flag, whether it may be
/// given several times, whether it is required, its choices and its default. An option without a name on the
/// command line is a place, such as `RIG`. Options of all commands are left out.
pub fn option_list() -> Value {
    let mut command = command();
    command.build();
    let commands = command.get_subcommands().filter(|command| !command.is_hide_set());
    let prints_json = |command: &&clap::Command| command.get_arguments().any(|arg| arg.get_id() == "wanted");
    let listed = commands.filter(prints_json).map(|command| {
        let options = command.get_arguments().filter(|arg| !arg.is_global_set() && arg.get_id() != "wanted");
        json!({
            "name": command.get_name(),
            "about": command.get_about().map(ToString::to_string),
            "options": options.filter(|arg| arg.get_id() != "help").map(option).collect::<Vec<_>>(),
        })
    });
    Value::Array(listed.collect())
}

fn option(arg: &Arg) -> Value {
    let takes_value = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
    let several = arg.get_num_args().is_some_and(|range| range.max_values() > 1);
    let choices = arg.get_possible_values();
    json!({
        "name": arg.get_long().unwrap_or(arg.get_id().as_str()),
        "is_place": arg.is_positional(),
        "is_flag": !takes_value,
        "may_be_empty": takes_value && arg.get_num_args().is_some_and(|range| range.min_values() == 0),
        "is_list": matches!(arg.get_action(), ArgAction::Append) || arg.is_positional() && several,
        "is_required": arg.is_required_set(),
        "value": arg.get_value_names().map(|names| names.iter().map(ToString::to_string).collect::<Vec<_>>()),
        "choices": if takes_value { choices.iter().map(|choice| choice.get_name().to_owned()).collect() } else { Vec::new() },
        "default": arg.get_default_values().first().map(|value| value.to_string_lossy().into_owned()),
        "help": arg.get_help().map(ToString::to_string),
    })
}
