//! `token add|list|revoke`: the token file of a server.

use serde_json::json;
use signorini_server::{Entry, NewToken, TokenFile};

use crate::arguments::TokenCommand;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::note;

pub(super) fn run(command: TokenCommand) -> Result<Exit, Failure> {
    match command {
        TokenCommand::Add {
            name,
            role,
            certificate,
            file,
        } => {
            let mut tokens = TokenFile::read_or_new(&file.path).map_err(usage)?;
            let proof = if certificate {
                NewToken::Certificate
            } else {
                NewToken::Bearer
            };
            let added = tokens.add(name, role, proof);
            let token = added.map_err(|why| Failure::new(Exit::Server, why))?;
            tokens.write(&file.path).map_err(usage)?;
            if let Some(token) = token {
                note("the token is shown this once; the file keeps its digest only\n");
                print(&format!("{token}\n"))?;
            }
        }
        TokenCommand::List { json, file } => {
            for entry in TokenFile::read(&file.path).map_err(usage)?.entries() {
                print(&line(entry, json))?;
            }
        }
        TokenCommand::Revoke { name, id, file } => {
            let mut tokens = TokenFile::read(&file.path).map_err(usage)?;
            if tokens.revoke(name, id.as_deref()) == 0 {
                let path = file.path.display();
                return Err(Failure::new(
                    Exit::Usage,
                    format!("{path} has no such token"),
                ));
            }
            tokens.write(&file.path).map_err(usage)?;
        }
    }
    Ok(Exit::Ok)
}

fn line(entry: &Entry, is_json: bool) -> String {
    let (name, role, id) = (entry.name(), entry.role(), entry.id());
    let created = entry.created();
    if is_json {
        let (name, role) = (name.as_str(), role.name());
        let object = json!({"name": name, "role": role, "id": id, "created": created});
        return format!("{object}\n");
    }
    format!("{name:32}  {role:5}  {id:11}  {created}\n")
}

fn usage(error: signorini_server::AccessError) -> Failure {
    Failure::new(Exit::Usage, error.to_string())
}
